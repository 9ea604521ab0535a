// Data in columns while the JIT's loop over steps runs: the same steps and the same data as without the loop, one step
// after the other; and which systems have none. (Emitted C++ and random systems: tools/gen, which asks for columns
// wherever they can be.)
#include <catch2/catch.hpp>

#include <algorithm>
#include <memory>
#include <string>

#include "compiler/pipeline/jit_loader.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/steps/derive_steps.hpp"
#include "runtime/core/core.hpp"

using namespace bip;
using namespace bip::pipeline;

namespace {

bool never() { return false; }

struct Prepared {
  Compilation c{CompileOptions{.root = "Root()"}};

  explicit Prepared(const std::string& body, steps::Columns columns = steps::Columns::WhereOfUse) {
    c.open_texts["m.bip"] = "package m\n" + body + "end\n";
    REQUIRE(compile(c, "m.bip", Stage::Image));
    steps::derive_steps(*c.lowered, columns);
  }
  [[nodiscard]] const lower::StepCells& cells() const { return c.lowered->steps.cells; }
};

struct Run {
  rt::u64 steps = 0;
  std::vector<rt::InteractionId> interactions;
  rt::State state;
  rt::Prng prng;
};

// In parts, so that the data go to the columns and back.
Run run(const rt::Image& image, rt::u64 part) {
  rt::Core core(image);
  REQUIRE(core.initialize());
  core.keep_list();
  REQUIRE(core.steps().has_steps());
  Run result{0, {}, {}, rt::Prng(7)};
  bool sound = true;
  for (int k = 0; k < 5; ++k) result.steps += core.steps().run(result.prng, part, never, sound);
  REQUIRE(sound);
  result.interactions = core.history().recent(std::min<rt::u64>(result.steps, rt::Core::kHistory));
  result.state = core.snapshot();
  return result;
}

// The loop's code on cells against step functions on interactions.
void compare(Prepared& model) {
  REQUIRE(model.cells().count > 0);
  REQUIRE(model.c.lowered->image.step_cells == model.cells().count);
  const Result<JitPlugin> plugin = load_jit();
  if (!plugin) {
#ifdef BIP_TEST_HAS_JIT
    FAIL("the build has LLVM, but its plug-in did not load");
#else
    WARN("the build has no LLVM: left out");
#endif
    return;
  }
  jit::MadeCode made;
  const Result<JitCode> code = (*plugin).compile(*model.c.lowered, {}, made);
  REQUIRE(code);
  jit::install(*model.c.lowered, made);
  const rt::Image& image = model.c.lowered->image;
  REQUIRE(image.steps_fn != nullptr);
  rt::Image stepwise = image, eager = image;
  stepwise.steps_fn = nullptr;
  eager.step_cells_pay = 1;
  for (const rt::u64 part : {1u, 2u, 17u, 300u, 5000u}) {
    const Run expected = run(stepwise, part);
    for (const rt::Image* other : {&image, static_cast<const rt::Image*>(&eager)}) {
      const Run looped = run(*other, part);
      CHECK(looped.steps == expected.steps);
      CHECK(looped.interactions == expected.interactions);
      CHECK(looped.prng == expected.prng);
      CHECK(looped.state.places == expected.state.places);
      CHECK(looped.state.data == expected.state.data);
    }
  }
}

// Eight leaves with two variables each under a tree; what goes up and down is the caller's, the leaves' other variable,
// too.
std::string tree(const std::string& type, const std::string& up, const std::string& down,
                 const std::string& other = "int") {
  return "  port type L(" + type +
         " v)\n"
         "  connector type Node(L a, L b)\n    data " +
         type +
         " m\n    export port L top(m)\n    define a b\n"
         "    on a b up { " +
         up + " } down { " + down +
         " }\n  end\n"
         "  connector type Top(L p)\n    define p\n  end\n"
         "  atom type Leaf(int start)\n    data " +
         type + " v\n    data " + other +
         " rest\n    export port L sync(v)\n    place P\n"
         "    initial to P do { v = start; }\n    on sync from P to P do { v = v + start; }\n  end\n"
         "  compound type Root()\n    for i in 0..8 component Leaf leaf[i](i * 7 - 20)\n"
         "    for i in 0..3 connector Node node[i](node[2 * i + 1].top, node[2 * i + 2].top)\n"
         "    for i in 3..7 connector Node node[i](leaf[2 * i - 6].sync, leaf[2 * i - 5].sync)\n"
         "    connector Top top(node[0].top)\n  end\n";
}

const std::string kLarger = "if (a.v > b.v) then m = a.v; else m = b.v; fi", kBoth = "a.v = m; b.v = m;";

// Pairs of two types, in turn among atoms; each pair alternates alone, and now and then all do something together.
std::string pairs(int count) {
  return "  port type S()\n  port type D(int v, bool w, string s)\n"
         "  connector type Swap(D a, D b)\n    define a b\n"
         "    on a b provided (a.v < 40 || b.w) down { a.v = b.v + 1; b.v = a.v - b.v; a.w = !b.w; b.s = a.s; }\n  "
         "end\n"
         "  connector type One(S p)\n    define p\n  end\n"
         "  atom type Ping(int k)\n    data int x = k, n = 0\n    data bool lit = true\n    data string name = "
         "\"ping\"\n    export port D give(x, lit, name)\n    export port S all()\n"
         "    place P\n    initial to P\n    on give from P to P\n    on all from P to P do { n = n + x; if (lit) then "
         "x = 0 - x; else name = \"off\"; fi }\n  end\n"
         "  atom type Pong()\n    data bool odd = false\n    data int y = 3\n    data string what = \"pong\"\n    "
         "export port D take(y, odd, what)\n    export port S again()\n"
         "    place P, Q\n    initial to P\n    on take from P to Q do { odd = !odd; }\n    on again from Q to P do { "
         "y = y * 3; }\n  end\n"
         "  compound type Pair(int k)\n    component Ping ping(k)\n    component Pong pong()\n    export port ping.all "
         "as all\n"
         "    connector Swap swap(ping.give, pong.take)\n    connector One again(pong.again)\n  end\n"
         "  compound type Root()\n    for i in 0.." +
         std::to_string(count) +
         " component Pair pair[i](i)\n    connector together(pair[*].all)\n      define [pair[*].all]\n  end\n";
}

}  // namespace

TEST_CASE("a tree's loops go over columns") {
  Prepared model(tree("int", kLarger, kBoth));
  compare(model);
  // Three variables of eight leaves, the largest value of all in one loop, then one over the leaves.
  CHECK(model.cells().columns.size() == 3);
  for (const rt::StepColumn& column : model.cells().columns) CHECK((column.distance == 3 && column.count == 8));
  CHECK(model.cells().pay > 1);
  REQUIRE(model.cells().shapes.size() == 1);
  for (const lower::StepOp& op : model.cells().shapes[0].ops) CHECK(op.kind != lower::StepOpKind::Place);
  CHECK(std::all_of(model.cells().shapes[0].strides.begin(), model.cells().shapes[0].strides.end(),
                    [](std::int32_t stride) { return stride == 0 || stride == 1; }));
}

TEST_CASE("what cannot be joined in any order runs as it is written, on cells") {
  for (const char* up : {"m = a.v - b.v;", "m = a.v * 2 + b.v;", "if (a.v > b.v) then m = a.v; else m = a.v - b.v; fi",
                         "if (a.v > 3) then m = a.v; else m = b.v; fi", "m = a.v + b.v;", "m = a.v * b.v;",
                         "m = a.v ^ b.v;", "if (b.v >= a.v) then m = a.v; else m = b.v; fi"}) {
    for (const char* down : {"a.v = m; b.v = m;", "a.v = m + 1; b.v = m;", "a.v = m; b.v = a.v - m;", "a.v = m;"}) {
      CAPTURE(up, down);
      Prepared model(tree("int", up, down));
      compare(model);
    }
  }
}

TEST_CASE("two types in turn, with guards, bools and strings, have columns") {
  for (const int count : {4, 9, 70}) {
    Prepared model(pairs(count));
    CAPTURE(count);
    compare(model);
    CHECK(model.cells().columns.size() >= 7);
  }
}

TEST_CASE("columns where they are of no use, too") {
  const std::string few =
      "  port type S()\n  connector type Two(S a, S b)\n    define a b\n  end\n"
      "  atom type A(int k)\n    data int n = k, m = 1\n    export port S p()\n    place P\n    initial to P\n    on p "
      "from P to P do { n = n + m; m = m - n * k; }\n  end\n"
      "  compound type Root()\n    component A a(1), b(2), c(3)\n    connector Two ab(a.p, b.p), bc(b.p, c.p)\n  end\n";
  CHECK(Prepared(few).cells().empty());
  Prepared model(few, steps::Columns::WherePossible);
  compare(model);
  CHECK(model.cells().pay == 1);
}

TEST_CASE("systems without columns") {
  // Variables of 64 bits, anywhere.
  CHECK(Prepared(tree("float", "m = a.v + b.v;", kBoth)).cells().empty());
  CHECK(Prepared(tree("int", kLarger, kBoth, "float")).cells().empty());
  // A transition with a guard is the core's, and it needs data where they were.
  std::string guarded = tree("int", kLarger, kBoth);
  guarded.replace(guarded.find("from P to P do"), 14, "from P to P provided (v < 100) do");
  CHECK(Prepared(guarded).cells().empty());
  // A division that may fault: the same.
  CHECK(Prepared(tree("int", "m = a.v / b.v;", kBoth)).cells().empty());
  // Nobody has data but connectors, and theirs are gone after a step.
  const std::string none =
      "  port type S()\n  connector type One(S a)\n    data int z\n    define a\n  end\n"
      "  atom type A()\n    export port S p()\n    place P\n    initial to P\n    on p from P to P\n  end\n"
      "  compound type Root()\n    component A a()\n    connector One one(a.p)\n  end\n";
  CHECK(Prepared(none, steps::Columns::WherePossible).cells().empty());
  // More kinds of steps than the loop asks for.
  std::string many = pairs(20);
  many.replace(many.rfind("  end\n"), 6, "");
  // At uneven distances.
  for (int k = 0; k < 12; ++k)
    many += "    connector Some some" + std::to_string(k) + "(pair[" + std::to_string(k * k % 20) + "].all)\n";
  many += "  end\n  connector type Some(S p)\n    define p\n  end\n";
  Prepared model(many);
  CHECK(model.c.lowered->steps.runs.size() > 6);
  CHECK(model.cells().empty());
  // Only for tests: the core takes those steps, and data go to and fro.
  Prepared mixed(many, steps::Columns::WherePossible);
  compare(mixed);
}
