// Local steps of a node of a distributed run by their compiled code: the same steps as one by one, up to a step that
// another node has a part in.
#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include "compiler/pipeline/jit_loader.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/steps/derive_steps.hpp"
#include "runtime/core/core.hpp"
#include "runtime/distributed/node.hpp"

using namespace bip;
using namespace bip::pipeline;

namespace {

const std::string kPairs = R"(package m
  port type P()
  connector type Two(P p, P q)
    define p q
  end
  atom type A()
    data int n
    export port P go(), back()
    place S, T
    initial to S do { n = 0; }
    on go from S to T do { n = n * 3 + 1; }
    on back from T to S do { n = n + 2; }
  end
  compound type Root()
    component A a[12]()
    for i in 0..6 connector Two go[i](a[2 * i].go, a[2 * i + 1].go), back[i](a[2 * i].back, a[2 * i + 1].back)
    connector Two across(a[0].go, a[11].go)
  end
end
)";

// A node with all of its list, as an engine starts it.
struct Started {
  rt::Node node;
  rt::Prng prng{7};
  Started(const rt::Image& image, const rt::Distribution& distribution, const rt::State& initial)
      : node(image, {}, distribution, 0) {
    node.core().keep_list();
    REQUIRE(node.start(initial));
  }
  rt::EnabledSet::Position draw() {
    const rt::u64 count = node.core().candidate_count();
    REQUIRE(count != 0);
    return node.core().enabled().drawn(count == 1 ? 0 : prng.below(count));
  }
  void begin(rt::EnabledSet::Position at, rt::u64 step) {
    std::vector<rt::u32> atoms;
    node.begin(at, step, atoms);
    while (node.work_count() != 0) node.run(0);
  }
};

rt::State saved(const rt::Node& node, const rt::State& initial) {
  rt::State state = initial;
  rt::SavedTime time;
  node.save(state, time);
  return state;
}

// Atoms from `elsewhere` on are at home on a second node. Returns how many steps were taken by compiled code.
rt::u64 compare(const rt::Image& image, rt::u32 elsewhere, rt::u64 part) {
  rt::Core core(image);
  REQUIRE(core.initialize());
  rt::Placement placement;
  placement.nodes = {"1", "2"};
  for (rt::u32 atom = 0; atom < image.atoms.size; ++atom) placement.home.push_back(atom < elsewhere ? 0 : 1);
  const rt::Distribution distribution = rt::distribute(core.tables(), core.priorities(), placement);
  const rt::State initial = core.snapshot();
  Started compiled(image, distribution, initial), stepwise(image, distribution, initial);
  REQUIRE(compiled.node.has_compiled());
  rt::u64 taken = 0, borders = 0;
  for (rt::u64 round = 1; round <= 60; ++round) {
    rt::InteractionId drawn;
    const rt::u64 done = compiled.node.take_compiled(compiled.prng, part, drawn);
    CHECK(done <= part);
    taken += done;
    for (rt::u64 k = 0; k < done; ++k) {
      const rt::EnabledSet::Position at = stepwise.draw();
      REQUIRE(stepwise.node.is_whole(at.interaction));
      REQUIRE(stepwise.node.take_whole(at, round));
    }
    if (drawn.is_valid()) {
      const rt::EnabledSet::Position at = stepwise.draw();
      REQUIRE(at.interaction == drawn);
      CHECK_FALSE(compiled.node.is_whole(drawn));
      compiled.begin({drawn, 0}, round);
      stepwise.begin(at, round);
      ++borders;
    } else {
      CHECK(done == part);
    }
    CHECK(compiled.node.core().enabled().list_order() == stepwise.node.core().enabled().list_order());
    CHECK((saved(compiled.node, initial) == saved(stepwise.node, initial)));
    CHECK(compiled.node.landed() == stepwise.node.landed());
    CHECK(compiled.node.outbox().size() == stepwise.node.outbox().size());
  }
  CHECK((borders != 0) == (elsewhere < image.atoms.size));
  return taken;
}

}  // namespace

TEST_CASE("compiled steps of a node are its steps, up to one that another node has a part in") {
  Compilation c{CompileOptions{.root = "Root()"}};
  c.open_texts["m.bip"] = kPairs;
  REQUIRE(compile(c, "m.bip", Stage::Image));
  steps::derive_steps(*c.lowered);
  const Result<JitPlugin> plugin = load_jit();
  if (!plugin) {
    WARN("the build has no LLVM: left out");
    return;
  }
  jit::MadeCode made;
  const Result<JitCode> code = (*plugin).compile(*c.lowered, {}, made);
  REQUIRE(code);
  jit::install(*c.lowered, made);
  for (const rt::u64 part : {rt::u64{1}, rt::u64{17}, rt::Node::kMostCompiled}) {
    CHECK(compare(c.lowered->image, 12, part) == 60 * part);
    CHECK(compare(c.lowered->image, 8, part) > 50 * part);
  }
}
