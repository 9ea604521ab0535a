// Long runs on arrays in inner order take the steps that they take on the core's arrays: the same draws, the same end.
#include <catch2/catch.hpp>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "compiler/pipeline/jit_loader.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/steps/derive_steps.hpp"
#include "runtime/core/core.hpp"

using namespace bip;
using namespace bip::pipeline;

namespace {

constexpr const char* kTypes =
    "package m\n  port type S()\n  port type L(int x)\n"
    "  connector type Three(S a, S b, S c)\n    define a b c\n  end\n"
    "  connector type Two(S a, S b)\n    define a b\n  end\n"
    "  connector type One(S a)\n    define a\n  end\n"
    "  connector type Call(S a, S b, S c)\n    define a' b c\n  end\n"
    "  connector type Move(L a, L b)\n    define a b\n"
    "    on a b provided (a.x > 0 && b.x < 9) down { a.x = a.x - 1; b.x = b.x + 1; }\n  end\n"
    "  atom type Phil()\n    data int meals = 0\n    export port S take(), give()\n    place THINKS, EATS\n"
    "    initial to THINKS\n    on take from THINKS to EATS do { meals = meals + 1; }\n"
    "    on give from EATS to THINKS\n  end\n"
    "  atom type Fork()\n    export port S take(), give()\n    place FREE, TAKEN\n    initial to FREE\n"
    "    on take from FREE to TAKEN\n    on give from TAKEN to FREE\n  end\n"
    "  atom type Cell()\n    data int x = 5\n    export port L give(x), take(x)\n    place P\n    initial to P\n"
    "    on give from P to P\n    on take from P to P\n  end\n";

// Components and connectors in random order.
std::string shuffled(std::vector<std::string> components, std::vector<std::string> connectors, unsigned seed,
                     const std::string& rules = "") {
  std::mt19937 numbers(seed);
  std::shuffle(components.begin(), components.end(), numbers);
  std::shuffle(connectors.begin(), connectors.end(), numbers);
  std::string text = std::string(kTypes) + "  compound type Root()\n";
  for (const std::string& line : components) text += "    component " + line + "\n";
  for (const std::string& line : connectors) text += "    connector " + line + "\n";
  return text + rules + "  end\nend\n";
}

std::string name(const char* what, int i) { return what + std::to_string(i); }

std::string table(int n, unsigned seed, bool with_rules = false) {
  std::vector<std::string> components, connectors;
  std::string rules;
  for (int i = 0; i < n; ++i) {
    components.push_back("Phil " + name("p", i) + "()");
    components.push_back("Fork " + name("f", i) + "()");
    for (const std::string port : {"take", "give"}) {
      connectors.push_back("Three " + name(port.c_str(), i) + "(" + name("p", i) + "." + port + ", " + name("f", i) +
                           "." + port + ", " + name("f", (i + 1) % n) + "." + port + ")");
    }
    if (with_rules)
      rules += "    priority " + name("r", i) + " " + name("give", i) + ":* < " + name("take", (i + 2) % n) + ":*\n";
  }
  return shuffled(components, connectors, seed, rules);
}

std::string chain_of_cells(int n, unsigned seed) {
  std::vector<std::string> components, connectors;
  for (int i = 0; i < n; ++i) {
    components.push_back("Cell " + name("c", i) + "()");
    if (i > 0)
      connectors.push_back("Move " + name("m", i) + "(" + name("c", i - 1) + ".give, " + name("c", i) + ".take)");
  }
  return shuffled(components, connectors, seed);
}

// Nothing is regular: atoms that are bound at random, and broadcasts.
std::string at_random(int n, unsigned seed) {
  std::mt19937 numbers(seed);
  const auto any = [&] { return static_cast<int>(numbers() % static_cast<unsigned>(n)); };
  std::vector<std::string> components, connectors;
  for (int i = 0; i < n; ++i) components.push_back("Fork " + name("f", i) + "()");
  for (int i = 0; i < 2 * n; ++i) {
    const int a = any(), b = any(), c = any();
    if (a == b || b == c || a == c) continue;
    const std::string port = i % 2 == 0 ? ".take" : ".give";
    const char* const type = i % 7 == 0 ? "Call " : "Three ";
    connectors.push_back(type + name("k", i) + "(" + name("f", a) + port + ", " + name("f", b) + port + ", " +
                         name("f", c) + (i % 5 == 0 ? ".take" : port) + ")");
  }
  for (int i = 0; i < n; ++i) connectors.push_back("One " + name("one", i) + "(" + name("f", i) + ".give)");
  return shuffled(components, connectors, seed);
}

bool goes_on_for_ever() { return false; }

struct Ending {
  rt::u64 steps = 0;
  std::vector<rt::InteractionId> interactions, order;
  rt::Prng prng;
  rt::State state;
};

// In parts, so that arrays are filled and emptied in between.
Ending run(const rt::Image& image, std::initializer_list<rt::u64> parts) {
  rt::Core core(image);
  REQUIRE(core.initialize());
  core.keep_list();
  REQUIRE(core.steps().has_steps());
  Ending ending{0, {}, {}, rt::Prng(7), {}};
  for (const rt::u64 part : parts) {
    bool sound = true;
    const rt::u64 done = core.steps().run(ending.prng, part, goes_on_for_ever, sound);
    REQUIRE(sound);
    ending.steps += done;
    const std::vector<rt::InteractionId> recent = core.history().recent(std::min<rt::u64>(done, rt::Core::kHistory));
    ending.interactions.insert(ending.interactions.end(), recent.begin(), recent.end());
  }
  ending.order = core.enabled().list_order();
  ending.state = core.snapshot();
  return ending;
}

}  // namespace

TEST_CASE("steps in inner order are those in the source's order") {
  const Result<JitPlugin> plugin = load_jit();
  if (!plugin) {
    WARN("the build has no LLVM: left out");
    return;
  }
  const unsigned seed = GENERATE(1u, 2u, 3u);
  const bool is_forced = GENERATE(false, true);
  // Whether there must be inner steps.
  const auto [text, is_inner] =
      GENERATE_COPY(std::pair{table(2, seed), false}, std::pair{table(3, seed), false},
                    std::pair{table(5, seed), false}, std::pair{table(40, seed), true},
                    std::pair{table(30, seed, true), false}, std::pair{chain_of_cells(12, seed), false},
                    std::pair{at_random(6, seed), false}, std::pair{at_random(25, seed), false});
  Compilation c{CompileOptions{.root = "Root()"}};
  c.open_texts["m.bip"] = text;
  REQUIRE(compile(c, "m.bip", Stage::Image));
  steps::derive_steps(*c.lowered, is_forced ? steps::Columns::WherePossible : steps::Columns::WhereOfUse);
  if (c.lowered->steps.shapes.empty()) return;
  jit::MadeCode made;
  const Result<JitCode> code = (*plugin).compile(*c.lowered, {}, made);
  REQUIRE(code);
  jit::install(*c.lowered, made);
  const rt::Image& image = c.lowered->image;
  if (is_inner) REQUIRE(image.inner_steps.runs.size != 0);
  if (is_inner) REQUIRE(image.inner_steps.steps_fn != nullptr);
  rt::Image always = image, never = image;
  always.inner_steps.pay = 1;
  never.inner_steps = {};
  rt::Image without_loop = always;
  without_loop.inner_steps.steps_fn = nullptr;
  for (const std::initializer_list<rt::u64> parts :
       {std::initializer_list<rt::u64>{1, 1, 2, 3, 300}, {20'000, 7, 4'096}, {500}}) {
    const Ending expected = run(never, parts);
    for (const rt::Image& other : {image, always, without_loop}) {
      const Ending found = run(other, parts);
      CHECK(found.steps == expected.steps);
      CHECK(found.interactions == expected.interactions);
      CHECK(found.prng == expected.prng);
      CHECK(found.order == expected.order);
      CHECK(found.state == expected.state);
    }
  }
}

TEST_CASE("models whose own order is regular have no inner steps") {
  Compilation c{CompileOptions{.root = "Root()"}};
  std::string text =
      std::string(kTypes) + "  compound type Root()\n    component Phil p[50]()\n    component Fork f[50]()\n";
  for (const std::string port : {"take", "give"})
    text += "    for i in 0..50 connector Three " + port + "[i](p[i]." + port + ", f[i]." + port +
            ", f[(i + 1) % 50]." + port + ")\n";
  c.open_texts["m.bip"] = text + "  end\nend\n";
  REQUIRE(compile(c, "m.bip", Stage::Image));
  steps::derive_steps(*c.lowered);
  CHECK(!c.lowered->steps.loop.empty());
  CHECK(c.lowered->image.inner_steps.runs.size == 0);
}
