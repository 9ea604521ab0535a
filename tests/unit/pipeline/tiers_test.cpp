// Runs that begin interpreted and go on with machine code: the same run, whenever the code comes.
#include <catch2/catch.hpp>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "bip/run.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/pipeline/tiers.hpp"
#include "compiler/interp/interp.hpp"
#include "tests/unit/base/contents.hpp"

using namespace bip;
using namespace bip::pipeline;
using bip::testing::contents;

namespace {

// Stores that hand pieces on and may lose one now and then: guards, transfers, actions; if they lose any, an internal
// port whose guard has no compiled step, and an end.
std::string stores(bool lose) {
  return std::string(
             "package m\n"
             "  port type S()\n  port type L(int x)\n"
             "  connector type Move(L a, L b)\n    define a b\n"
             "    on a b provided (a.x > 0 && b.x < 9) down { a.x = a.x - 1; b.x = b.x + 1; }\n  end\n"
             "  atom type Store(int x0)\n"
             "    data int x = x0, seen = 0, luck = 1\n"
             "    export port L give(x), take(x)\n") +
         (lose ? "    port S lose()\n" : "") +
         "    place P\n    initial to P\n"
         "    on give from P to P do { luck = luck * 1103515245 + 12345; }\n"
         "    on take from P to P do { seen = seen + x; }\n" +
         (lose
              ? "    on lose from P to P provided (x > 0 && (luck & 3072) == 0) do { x = x - 1; luck = luck + 1024; }\n"
              : "") +
         "  end\n"
         "  compound type R()\n    component Store s[6](5)\n"
         "    for i in 0..6 connector Move m[i](s[i].give, s[(i + 1) % 6].take)\n  end\n"
         "end\n";
}

struct TieredModel {
  Compilation c{CompileOptions{.root = "R()"}};
  std::unique_ptr<interp::Interpreter> interpreter;
  explicit TieredModel(bool lose) {
    c.open_texts["m.bip"] = stores(lose);
    REQUIRE(compile(c, "m.bip", Stage::Image));
    interpreter = std::make_unique<interp::Interpreter>(*c.lowered);
  }
};

// Everything that the run says.
std::string said(const rt::Image& image, std::uint64_t seed, rt::Policy policy, bool silent, rt::NewCode* new_code) {
  rt::RunOptions options;
  options.seed = seed;
  options.has_seed = true;
  options.limit = 3000;
  options.policy = policy;
  options.silent = silent;
  options.format = silent ? rt::TraceFormat::Steps : rt::TraceFormat::Bip2;
  options.new_code = new_code;
  std::FILE* out = std::tmpfile();
  (void)rt::run(image, options, out, stderr);
  return contents(out);
}

// A row of code that tells when it has been called so often, and does what it did.
struct Signal {
  rt::Code code;
  std::uint64_t left;
  rt::NewCode* new_code;
};
std::int32_t count_down(const void* context, rt::Cell* self, rt::Cell* all, const std::uint32_t* bind) {
  auto& signal = *const_cast<Signal*>(static_cast<const Signal*>(context));
  if (signal.left != 0 && --signal.left == 0) signal.new_code->is_ready.store(true);
  return signal.code.fn(signal.code.context, self, all, bind);
}

void wait_for(rt::NewCode& code) {
  for (int k = 0; k < 6000 && !code.is_ready.load(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

}  // namespace

TEST_CASE("machine code that comes during a run changes nothing but its speed") {
  if (!load_jit()) {
#ifdef BIP_TEST_HAS_JIT
    FAIL("the build has LLVM, but its plug-in did not load");
#else
    WARN("the build has no LLVM: left out");
#endif
    return;
  }
  const bool lose = GENERATE(false, true);
  for (const rt::Policy policy : {rt::Policy::Uniform, rt::Policy::First, rt::Policy::Fair}) {
    for (const bool silent : {false, true}) {
      const std::uint64_t seed = 7 + static_cast<std::uint64_t>(policy);
      const TieredModel plain(lose);
      const std::string expected = said(plain.c.lowered->image, seed, policy, silent, nullptr);
      for (const std::uint64_t calls : {1, 2, 17, 90, 180}) {
        TieredModel model(lose);
        Tiers tiers(*model.c.lowered, {}, 0);
        rt::NewCode& made = tiers.new_code();
        wait_for(made);
        REQUIRE(made.is_ready.load());
        // Not yet: when this row has been called so often.
        made.is_ready.store(false);
        std::vector<Signal> signals;
        signals.reserve(1);
        std::size_t row = 0;
        while (row < model.c.lowered->units.size() && model.c.lowered->units[row].kind != lower::CodeKind::Guard) ++row;
        REQUIRE(row < model.c.lowered->units.size());
        signals.push_back({model.c.lowered->codes[row], calls, &made});
        const rt::Code interpreted = model.c.lowered->codes[row];
        model.c.lowered->codes[row] = {&count_down, signals.data()};
        CHECK(said(model.c.lowered->image, seed, policy, silent, &made) == expected);
        CHECK(signals[0].left == 0);
        // It was taken: the row is neither ours nor the interpreter's.
        CHECK(model.c.lowered->codes[row].fn != &count_down);
        CHECK(model.c.lowered->codes[row].fn != interpreted.fn);
        CHECK((model.c.lowered->image.step_fns.size != 0) == !lose);
      }
    }
  }
}

TEST_CASE("a run that ends early does not wait for its code") {
  TieredModel model(true);
  const auto started = std::chrono::steady_clock::now();
  {
    Tiers tiers(*model.c.lowered, {}, 3'600'000);
    CHECK_FALSE(tiers.new_code().is_ready.load());
    CHECK(tiers.summary() == "code: interpreted\n");
  }
  // Far less than what its code would wait.
  CHECK(std::chrono::steady_clock::now() - started < std::chrono::seconds(600));
}
