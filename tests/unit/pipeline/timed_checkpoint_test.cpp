// Checkpoints of models with time: the instant and the clocks, also of other speeds, are those of the run; odd bytes
// are refused, or are a state.
#include <catch2/catch.hpp>

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "compiler/interp/interp.hpp"
#include "compiler/pipeline/pipeline.hpp"

#include "runtime/engine/checkpoints.hpp"
#include "runtime/trace/recorded.hpp"
#include "tests/unit/base/contents.hpp"

namespace {

using namespace bip::rt;

constexpr const char* kTanks =
    "package m\n"
    "  port type P()\n"
    "  connector type Two(P a, P b)\n    define a b\n  end\n"
    "  atom type Tank(float speed)\n"
    "    clock level, rest\n    data int n = 0\n"
    "    export port P full(), empty()\n"
    "    place FILLS, DRAINS\n    initial to FILLS do { level' = speed; }\n"
    "    on full from FILLS to DRAINS provided (level >= 1) do { rest = 0; n = n + 1; level' = 0.0; }\n"
    "    on empty from DRAINS to FILLS provided (rest >= 1) do { level = 0; level' = speed; }\n"
    "  end\n"
    "  compound type R()\n"
    "    component Tank a(0.3), b(0.7), c(1.0)\n"
    "    connector Two x(a.full, b.full), y(b.empty, c.full), z(a.empty, c.empty)\n"
    "  end\n"
    "end\n";

// Lets time pass, changes of ports on the way included.
void pass_to(Core& core, std::int64_t instant) {
  std::vector<std::int64_t> ends;
  while (core.now() < instant) {
    const std::int64_t next = std::min(instant, core.time().next_change());
    REQUIRE(next <= core.time().wait_limit(ends));
    REQUIRE(core.time().advance(next));
  }
}

}  // namespace

TEST_CASE("a checkpoint of a model with time has its instant and clocks") {
  bip::pipeline::Compilation c{bip::pipeline::CompileOptions{}};
  c.open_texts["m.bip"] = kTanks;
  REQUIRE(bip::pipeline::compile(c, "m.bip", bip::pipeline::Stage::Image));
  const bip::interp::Interpreter interpreter(*c.lowered);
  const Image& image = c.lowered->image;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    char name[] = "/tmp/bip-checkpoint-XXXXXX";
    const int file = mkstemp(name);
    REQUIRE(file >= 0);
    close(file);
    std::FILE* const written = std::tmpfile();
    RunOptions options;
    options.seed = seed;
    options.has_seed = true;
    options.limit = 100;
    options.silent = true;
    options.engine = Engine::Simulated;
    options.nodes = 3;
    options.network_faults = "lose 10%, slow 2 x3";
    options.format = TraceFormat::Binary;
    options.trace_path = "/proc/self/fd/" + std::to_string(fileno(written));
    options.checkpoint_every = 30000000;
    options.checkpoint_path = name;
    std::FILE* const said = std::tmpfile();
    const RunResult run_result = run(image, options, said, said);
    std::fclose(said);
    REQUIRE(run_result.exit_code == 0);
    const std::string trace = bip::testing::contents(written);

    // The recorded steps before it lead there.
    Core core(image), followed(image);
    REQUIRE(core.initialize());
    REQUIRE(followed.initialize());
    Checkpoint checkpoint;
    REQUIRE(resume(core, name, checkpoint) == "");
    std::remove(name);
    REQUIRE(checkpoint.steps > 0);
    CHECK(core.now() > 0);
    RecordedReader reader;
    RecordedBegin begin;
    RecordedEnd end;
    REQUIRE(reader.open(trace, begin).empty());
    for (std::uint64_t step = 0; step < checkpoint.steps; ++step) {
      EnabledSet::Position at{};
      REQUIRE(reader.next(at, end) == RecordedReader::Next::Step);
      pass_to(followed, reader.instant());
      REQUIRE(followed.take(at));
    }
    pass_to(followed, core.now());
    CHECK(followed.snapshot() == checkpoint.state);
    CHECK(core.snapshot() == checkpoint.state);

    const std::string bytes = print_checkpoint(core, checkpoint);
    Prng draws(seed);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      Checkpoint cut = checkpoint;
      CHECK_FALSE(read_checkpoint(core, std::string_view(bytes).substr(0, size), cut).empty());
      std::string odd = bytes;
      odd[size] = static_cast<char>(draws.below(256));
      Checkpoint other = checkpoint;
      Core from_odd(image);
      REQUIRE(from_odd.initialize());
      if (!read_checkpoint(from_odd, odd, other).empty() || !from_odd.restore(other.state)) continue;
      for (int step = 0; step < 5 && from_odd.candidate_count() != 0; ++step) {
        if (!from_odd.take(from_odd.position(0))) break;
      }
    }
  }
}
