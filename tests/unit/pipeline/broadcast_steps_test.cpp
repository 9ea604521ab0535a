// Compiled steps of broadcasts with data: for every set of receivers that are ready the state is the core's.
#include <catch2/catch.hpp>

#include <algorithm>
#include <string>

#include "compiler/pipeline/jit_loader.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/steps/derive_steps.hpp"
#include "runtime/core/core.hpp"

using namespace bip;
using namespace bip::pipeline;

namespace {

// Two senders and six receivers each: all of them in the first clause, some in others; the last `always` of the
// receivers have one place. `turns`: the sender leaves its place.
std::string broadcasts(int always, bool turns) {
  const std::string names = "abcdef";
  std::string parameters, all, down;
  for (const char name : names) {
    parameters += std::string(", N ") + name;
    all += std::string(" ") + name;
    down += std::string(" ") + name + ".v = s.v;";
  }
  std::string text =
      "package m\n  port type S()\n  port type N(int v)\n  connector type One(S p)\n    define p\n  end\n"
      "  connector type All(N s" +
      parameters + ")\n    data int sum\n    define s'" + all +
      "\n"
      "    on s" +
      all + " down {" + down +
      " }\n"
      "    on s a b e f down { sum = a.v + b.v; s.v = s.v + sum; e.v = sum; }\n"
      "    on s c d e f down { s.v = s.v + c.v; d.v = s.v; }\n    on s down { s.v = s.v * 3; }\n  end\n"
      "  atom type Sender()\n    data int v = 1\n    export port N send(v)\n    export port S count()\n"
      "    place R, C\n    initial to R\n";
  text += turns ? "    on send from R to C\n    on count from C to R do { v = v + 1; }\n  end\n"
                : "    on send from R to R do { v = v + 2; }\n    on count from R to R do { v = v + 1; }\n  end\n";
  text +=
      "  atom type Receiver()\n    data int v = 0, heard = 0\n    export port N hear(v)\n"
      "    export port S shut(), reopen()\n    place O, X\n    initial to O\n"
      "    on hear from O to O do { heard = heard + v; }\n    on shut from O to X\n    on reopen from X to O\n  end\n"
      "  atom type Always()\n    data int v = 0, heard = 0\n    export port N hear(v)\n    place O\n    initial to O\n"
      "    on hear from O to O do { heard = heard + v; }\n  end\n  compound type Root()\n";
  for (const std::string k : {"0", "1"}) {
    text += "    component Sender s" + k + "()\n";
    std::string ports;
    for (int i = 0; i < 6; ++i) {
      const std::string name = std::string(1, names[static_cast<std::size_t>(i)]) + k;
      text += std::string("    component ") + (i < 6 - always ? "Receiver " : "Always ") + name + "()\n";
      ports += ", " + name + ".hear";
    }
    text += "    connector All all" + k + "(s" + k + ".send" + ports + ")\n";
    text += "    connector One count" + k + "(s" + k + ".count)\n";
    for (int i = 0; i < 6 - always; ++i) {
      const std::string name = std::string(1, names[static_cast<std::size_t>(i)]) + k;
      text += "    connector One shut" + name + "(" + name + ".shut)\n";
      text += "    connector One reopen" + name + "(" + name + ".reopen)\n";
    }
  }
  return text + "  end\nend\n";
}

bool never_interrupted() { return false; }

rt::State state_after(const rt::Image& image, rt::u64 steps, std::uint64_t seed) {
  rt::Core core(image);
  REQUIRE(core.initialize());
  core.keep_list();
  rt::Prng prng(seed);
  if (core.steps().has_steps()) {
    bool sound = true;
    REQUIRE(core.steps().run(prng, steps, never_interrupted, sound) == steps);
    REQUIRE(sound);
  } else {
    for (rt::u64 step = 0; step < steps; ++step) {
      const std::uint64_t count = core.candidate_count();
      REQUIRE(core.take(core.enabled().drawn(count == 1 ? 0 : prng.below(count))));
    }
  }
  return core.snapshot();
}

}  // namespace

TEST_CASE("compiled broadcasts hand on the data of the clause whose ports are ready") {
  const Result<JitPlugin> plugin = load_jit();
  if (!plugin) {
    WARN("the build has no LLVM: left out");
    return;
  }
  const int always = GENERATE(0, 2, 6);
  const bool turns = GENERATE(false, true);
  Compilation c{CompileOptions{.root = "Root()"}};
  c.open_texts["m.bip"] = broadcasts(always, turns);
  REQUIRE(compile(c, "m.bip", Stage::Image));
  steps::derive_steps(*c.lowered, GENERATE(steps::Columns::WhereOfUse, steps::Columns::WherePossible));
  // Each interaction has a step: the broadcasts, too.
  rt::u32 known = 0;
  for (const rt::StepRun& run : c.lowered->steps.runs) known += run.count;
  REQUIRE(known == 2 * (2 + 2 * (6 - static_cast<rt::u32>(always))));
  jit::MadeCode made;
  const Result<JitCode> code = (*plugin).compile(*c.lowered, {}, made);
  REQUIRE(code);
  jit::install(*c.lowered, made);
  rt::Image plain = c.lowered->image;
  plain.step_fns = {};
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    for (const rt::u64 steps : {3u, 50u, 5000u}) {
      const rt::State compiled = state_after(c.lowered->image, steps, seed);
      const rt::State expected = state_after(plain, steps, seed);
      CHECK(compiled.data == expected.data);
      CHECK(compiled.places == expected.places);
    }
  }
}
