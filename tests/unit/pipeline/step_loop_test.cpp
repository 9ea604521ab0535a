// The JIT's loop over steps takes the steps that the core takes one by one, with the same random numbers: also where a
// draw may be repeated, where it draws a step that it does not know, and when the ring of recent interactions is full.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "compiler/pipeline/jit_loader.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/steps/derive_steps.hpp"
#include "runtime/core/core.hpp"

using namespace bip;
using namespace bip::pipeline;

namespace {

// Moves with guards around a ring of `cells`, a broadcast, and rendezvous of two to five: more kinds of steps than the
// loop asks for.
std::string cells(int count) {
  std::string text =
      "package m\n  port type S()\n  port type L(int x)\n"
      "  connector type Move(L a, L b)\n    define a b\n"
      "    on a b provided (a.x > 0 && b.x < 9) down { a.x = a.x - 1; b.x = b.x + 1; }\n  end\n"
      "  connector type Call(S c, S d, S e, S f, S g)\n    define c' d e f g\n  end\n";
  const std::string names = "abcde";
  for (std::size_t parts = 2; parts <= 5; ++parts) {
    std::string parameters, joined;
    for (std::size_t k = 0; k < parts; ++k) {
      parameters += std::string(k == 0 ? "" : ", ") + "S " + names[k];
      joined += std::string(" ") + names[k];
    }
    text += "  connector type All" + std::to_string(parts) + "(" + parameters + ")\n    define" + joined + "\n  end\n";
  }
  text +=
      "  atom type Cell(int x0)\n    data int x = x0, turns = 0\n"
      "    export port L give(x), take(x)\n    export port S turn(), odd(), even()\n"
      "    place P, Q\n    initial to P\n"
      "    on give from P to P\n    on take from P to P\n    on turn from P to P do { turns = turns + 1; }\n"
      "    on odd from P to Q do { turns = turns + x; }\n    on even from Q to P\n  end\n"
      "  compound type R(int n)\n    component Cell c[n](5)\n"
      "    for i in 0..n connector Move m[i](c[i].give, c[(i + 1) % n].take)\n"
      "    connector Call call(c[0].turn, c[1].odd, c[2].odd, c[3].odd, c[4].odd)\n";
  for (int parts = 2; parts <= 5; ++parts) {
    for (const char* port : {"odd", "even"}) {
      text += "    connector All" + std::to_string(parts) + " " + port + std::to_string(parts) + "(";
      for (int k = 0; k < parts; ++k)
        text += std::string(k == 0 ? "" : ", ") + "c[" + std::to_string(3 * k + parts) + "]." + port;
      text += ")\n";
    }
  }
  return text + "  end\n  compound type Root()\n    component R r(" + std::to_string(count) + ")\n  end\nend\n";
}

bool never_stopped() { return false; }

struct LoopRun {
  rt::u64 steps = 0;
  std::vector<rt::InteractionId> interactions;
  rt::Prng prng;
  rt::State state;
};

LoopRun run(const rt::Image& image, const rt::Prng& prng, rt::u64 limit) {
  rt::Core core(image);
  REQUIRE(core.initialize());
  core.keep_list();
  REQUIRE(core.steps().has_steps());
  LoopRun result{0, {}, prng, {}};
  bool sound = true;
  result.steps = core.steps().run(result.prng, limit, never_stopped, sound);
  REQUIRE(sound);
  result.interactions = core.history().recent(std::min<rt::u64>(result.steps, rt::Core::kHistory));
  result.state = core.snapshot();
  return result;
}

}  // namespace

TEST_CASE("the loop over steps draws and takes what the core does") {
  const Result<JitPlugin> plugin = load_jit();
  if (!plugin) {
#ifdef BIP_TEST_HAS_JIT
    FAIL("the build has LLVM, but its plug-in did not load");
#else
    WARN("the build has no LLVM: left out");
#endif
    return;
  }
  const int count = GENERATE(80, 119);
  Compilation c{CompileOptions{.root = "Root()"}};
  c.open_texts["m.bip"] = cells(count);
  REQUIRE(compile(c, "m.bip", Stage::Image));
  steps::derive_steps(*c.lowered);
  jit::MadeCode made;
  const Result<JitCode> code = (*plugin).compile(*c.lowered, {}, made);
  REQUIRE(code);
  jit::install(*c.lowered, made);
  REQUIRE(c.lowered->image.steps_fn != nullptr);
  REQUIRE(c.lowered->steps.loop.size() < c.lowered->steps.runs.size());
  rt::Image stepwise = c.lowered->image;
  stepwise.steps_fn = nullptr;
  // The first number of the second is 0, which may be drawn again.
  const auto odd = std::bit_cast<rt::Prng>(std::array<std::uint64_t, 4>{0, 3, 5, 0});
  for (const rt::Prng& prng : {rt::Prng(7), odd}) {
    for (const rt::u64 limit : {1u, 2u, 300u, 4097u, 40'000u}) {
      const LoopRun looped = run(c.lowered->image, prng, limit), expected = run(stepwise, prng, limit);
      CHECK(looped.steps == limit);
      CHECK(expected.steps == limit);
      CHECK(looped.interactions == expected.interactions);
      CHECK(looped.prng == expected.prng);
    }
  }
  // Who profiles looks between steps.
  c.lowered->calls_rows = true;
  jit::MadeCode pieces;
  const Result<JitCode> again = (*plugin).compile(*c.lowered, {}, pieces);
  REQUIRE(again);
  CHECK(pieces.steps_fn == nullptr);
  CHECK(pieces.step_fns.size() == made.step_fns.size());
}

namespace {

// What the policies `first` and `fair` choose, found in canonical order.
std::vector<rt::InteractionId> run_one_by_one(const rt::Image& image, bool follows, rt::u64 limit) {
  rt::Core core(image);
  REQUIRE(core.initialize());
  std::vector<rt::InteractionId> interactions;
  while (interactions.size() < limit && core.candidate_count() != 0) {
    const bool goes_on = follows && !interactions.empty();
    const rt::EnabledSet::Position at = core.position(goes_on ? core.enabled().next_after(interactions.back()) : 0);
    interactions.push_back(at.interaction);
    REQUIRE(core.take(at));
  }
  return interactions;
}

std::vector<rt::InteractionId> run_in_order(const rt::Image& image, bool follows, rt::u64 limit, rt::u64 part) {
  rt::Core core(image);
  REQUIRE(core.initialize());
  core.keep_ordered_list();
  rt::StepOrder order{0, follows};
  std::vector<rt::InteractionId> interactions;
  bool sound = true;
  while (interactions.size() < limit) {
    const rt::u64 wanted = std::min<rt::u64>(part, limit - interactions.size());
    const rt::u64 done = core.steps().run(order, wanted, never_stopped, sound);
    REQUIRE(sound);
    const std::vector<rt::InteractionId> recent = core.history().recent(done);
    interactions.insert(interactions.end(), recent.begin(), recent.end());
    if (done < wanted) break;
  }
  return interactions;
}

}  // namespace

TEST_CASE("compiled steps in order are those that the core takes") {
  const Result<JitPlugin> plugin = load_jit();
  if (!plugin) {
    WARN("the build has no LLVM: left out");
    return;
  }
  // Two levels of the order of members, and three.
  const int count = GENERATE(20, 80, 4200);
  Compilation c{CompileOptions{.root = "Root()"}};
  c.open_texts["m.bip"] = cells(count);
  REQUIRE(compile(c, "m.bip", Stage::Image));
  steps::derive_steps(*c.lowered);
  REQUIRE(!c.lowered->steps.entries.empty());
  jit::MadeCode made;
  const Result<JitCode> code = (*plugin).compile(*c.lowered, {}, made);
  REQUIRE(code);
  jit::install(*c.lowered, made);
  for (const bool follows : {false, true}) {
    CHECK(run_in_order(c.lowered->image, follows, 20'000, 1000) == run_one_by_one(c.lowered->image, follows, 20'000));
  }
}

namespace {

// Twelve philosophers: a list of five to twelve interactions, which is short at some times and long at others.
std::string philosophers() {
  std::string text =
      "package m\n  port type S()\n  connector type Three(S a, S b, S c)\n    define a b c\n  end\n"
      "  atom type Phil()\n    data int meals = 0\n    export port S take(), give()\n    place THINKS, EATS\n"
      "    initial to THINKS\n    on take from THINKS to EATS do { meals = meals + 1; }\n"
      "    on give from EATS to THINKS\n  end\n"
      "  atom type Fork()\n    export port S take(), give()\n    place FREE, TAKEN\n    initial to FREE\n"
      "    on take from FREE to TAKEN\n    on give from TAKEN to FREE\n  end\n"
      "  compound type Root()\n    component Phil p[12]()\n    component Fork f[12]()\n";
  for (const std::string port : {"take", "give"})
    text += "    for i in 0..12 connector Three " + port + "[i](p[(i * 5) % 12]." + port + ", f[(i * 5) % 12]." + port +
            ", f[(i * 5 + 1) % 12]." + port + ")\n";
  return text + "  end\nend\n";
}

// Numbers on a graph of two random circles through all nodes: an edge is enabled if its first node is not far ahead.
// Each node has four edges and a connector of its own, so nearly all steps are of two kinds.
std::string graph(int nodes) {
  std::string text =
      "package m\n  port type L(int x, int seen)\n"
      "  connector type Edge(L a, L b)\n    define a b\n"
      "    on a b provided (a.x < b.x + 3) down { a.x = (a.x + 1) & 7; b.x = (b.x + a.x) & 15; b.seen = a.x; }\n  end\n"
      "  connector type One(L a)\n    define a\n    on a provided (a.seen > a.x) down { a.seen = 0; }\n  end\n"
      "  atom type Node()\n    data int x = 0, seen = 0\n    export port L talk(x, seen)\n    place P\n"
      "    initial to P\n    on talk from P to P\n  end\n"
      "  compound type Root()\n    component Node n[" +
      std::to_string(nodes) + "]()\n";
  std::mt19937 numbers(static_cast<unsigned>(nodes));
  std::vector<int> circle(static_cast<std::size_t>(nodes));
  std::iota(circle.begin(), circle.end(), 0);
  for (const std::string round : {"e", "f"}) {
    std::shuffle(circle.begin(), circle.end(), numbers);
    for (std::size_t k = 0; k < circle.size(); ++k) {
      const std::string a = std::to_string(circle[k]), b = std::to_string(circle[(k + 1) % circle.size()]);
      text += "    connector Edge " + round + std::to_string(k) + "(n[" + a + "].talk, n[" + b + "].talk)\n";
      if (round == "e") text += "    connector One o" + std::to_string(k) + "(n[" + a + "].talk)\n";
    }
  }
  return text + "  end\nend\n";
}

}  // namespace

TEST_CASE("the loop takes steps whose operands are in a table") {
  const Result<JitPlugin> plugin = load_jit();
  if (!plugin) {
    WARN("the build has no LLVM: left out");
    return;
  }
  const auto [text, has_table] =
      GENERATE(std::pair{graph(4), false}, std::pair{graph(40), false}, std::pair{graph(500), true});
  Compilation c{CompileOptions{.root = "Root()"}};
  c.open_texts["m.bip"] = text;
  REQUIRE(compile(c, "m.bip", Stage::Image));
  steps::derive_steps(*c.lowered);
  if (has_table) REQUIRE(!c.lowered->steps.table.empty());
  jit::MadeCode made;
  const Result<JitCode> code = (*plugin).compile(*c.lowered, {}, made);
  REQUIRE(code);
  jit::install(*c.lowered, made);
  if (has_table) REQUIRE(c.lowered->image.steps_fn != nullptr);
  rt::Image stepwise = c.lowered->image;
  stepwise.steps_fn = nullptr;
  for (const rt::u64 limit : {1u, 2u, 300u, 4097u, 40'000u}) {
    const LoopRun looped = run(c.lowered->image, rt::Prng(7), limit), expected = run(stepwise, rt::Prng(7), limit);
    CHECK(looped.steps == expected.steps);
    CHECK(looped.interactions == expected.interactions);
    CHECK(looped.prng == expected.prng);
    CHECK(looped.state == expected.state);
  }
  for (const bool follows : {false, true}) {
    CHECK(run_in_order(c.lowered->image, follows, 2'000, 1000) == run_one_by_one(c.lowered->image, follows, 2'000));
  }
}

TEST_CASE("a short list is searched for the next interaction") {
  const Result<JitPlugin> plugin = load_jit();
  if (!plugin) {
    WARN("the build has no LLVM: left out");
    return;
  }
  Compilation c{CompileOptions{.root = "Root()"}};
  c.open_texts["m.bip"] = philosophers();
  REQUIRE(compile(c, "m.bip", Stage::Image));
  steps::derive_steps(*c.lowered);
  jit::MadeCode made;
  const Result<JitCode> code = (*plugin).compile(*c.lowered, {}, made);
  REQUIRE(code);
  jit::install(*c.lowered, made);
  const rt::u64 part = GENERATE(1u, 7u, 1000u);
  for (const bool follows : {false, true}) {
    CHECK(run_in_order(c.lowered->image, follows, 5'000, part) == run_one_by_one(c.lowered->image, follows, 5'000));
  }
}
