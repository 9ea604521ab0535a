// Checkpoints of models with time: the instant and the clocks, also of other speeds, are those of the run; odd bytes
// are refused, or are a state. So are actions that are at work beside the others.
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
#include "tests/unit/runtime/odd_checkpoints.hpp"

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

// Cameras whose pictures take a while, and what uses them.
constexpr const char* kCameras =
    "package m\n"
    "  port type P()\n  port type N(int n)\n"
    "  connector type Send(N from_, N to_)\n"
    "    define from_ to_\n    on from_ to_ down { to_.n = from_.n; }\n"
    "  end\n"
    "  atom type Camera(int pause)\n"
    "    clock c unit millisecond\n    data int n = 0, twice = 0\n"
    "    export port N send(n)\n    port P look()\n"
    "    place WAITS, SEES\n    initial to WAITS do { c = 0; }\n"
    "    @async(budget=\"25ms\")\n"
    "    on look from WAITS to SEES provided (c >= pause) eager do { n = n + 1; twice = 2 * n; }\n"
    "    on send from SEES to WAITS do { c = 0; }\n"
    "  end\n"
    "  atom type User()\n"
    "    data int n = 0, sum = 0\n"
    "    export port N get(n)\n"
    "    place P\n    initial to P\n"
    "    on get from P to P do { sum = sum + n; }\n"
    "  end\n"
    "  compound type R()\n"
    "    component Camera a(3), b(7), c(11), d(20)\n    component User u, v\n"
    "    connector Send p(a.send, u.get), q(b.send, u.get), r(c.send, v.get), s(d.send, v.get)\n"
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

// `is_beside`: in some of the checkpoints actions are at work beside the others.
void check_checkpoints(const char* model, bool is_beside) {
  bip::pipeline::Compilation c{bip::pipeline::CompileOptions{}};
  c.open_texts["m.bip"] = model;
  REQUIRE(bip::pipeline::compile(c, "m.bip", bip::pipeline::Stage::Image));
  const bip::interp::Interpreter interpreter(*c.lowered);
  const Image& image = c.lowered->image;
  bool are_any_beside = false;
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
    are_any_beside = are_any_beside || !core.actions().working().empty();
    CHECK(bip::testing::check_odd_checkpoints(image, core, checkpoint, seed) != 0);
  }
  CHECK(are_any_beside == is_beside);
}

}  // namespace

TEST_CASE("a checkpoint of a model with time has its instant and clocks") { check_checkpoints(kTanks, false); }

TEST_CASE("a checkpoint has the actions that are at work beside the others") { check_checkpoints(kCameras, true); }
