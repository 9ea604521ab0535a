// The diagram of a set of states: it is the set, equal rests are one node, and what never changes is said once.
#include <catch2/catch.hpp>

#include <set>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/search.hpp"
#include "compiler/verify/state_diagram.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;
using verify::StateDiagram;

const char* const kTwoCounters = R"(package counters
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Counter(int most)
    data int n = 0
    data bool still = true
    export port Signal more(), less()
    place S
    initial to S
    on more from S to S provided (n < most) do { n = n + 1; }
    on less from S to S provided (n > -most) do { n = n - 1; }
  end
  compound type Root()
    component Counter a(2), b(1)
    connector One ma(a.more), la(a.less), mb(b.more), lb(b.less)
  end
end
)";

// All lists of answers, by question.
void list(const StateDiagram& d, std::uint32_t node, std::vector<std::int32_t> values, std::set<std::vector<std::int32_t>>& out) {
  for (const StateDiagram::Case& one : d.nodes[node]) {
    for (const StateDiagram::Answer& answer : one.answers) values[answer.question] = answer.value;
    if (one.next == StateDiagram::kEnd) out.insert(values);
    else list(d, one.next, values, out);
  }
}

TEST_CASE("the diagram of what a search has reached") {
  const gen::Compiled c = gen::compile_texts({kTwoCounters});
  REQUIRE(c.problem.empty());
  const interp::Interpreter interpreter(*c.lowered);
  const verify::Net net = verify::build_net(*c.system);
  verify::StateCollector states(*c.system, c.lowered->image);
  REQUIRE(states.can_tell());
  std::set<std::vector<std::int32_t>> expected;
  const verify::SearchLimits limits{.end = verify::seconds_from_now(20), .report = {}, .visit = [&](const rt::State& state) { states.add(state); }};
  const verify::SearchResult all = verify::search(net, c.lowered->image, {}, {}, limits);
  REQUIRE(all.end == verify::SearchEnd::Exhausted);
  CHECK(all.states == 15);
  for (int a = -2; a <= 2; ++a) {
    for (int b = -1; b <= 1; ++b) expected.insert({0, a, 1, 0, b, 1});
  }
  const StateDiagram diagram = states.diagram();
  std::set<std::vector<std::int32_t>> found;
  list(diagram, static_cast<std::uint32_t>(diagram.nodes.size()) - 1, std::vector<std::int32_t>(diagram.questions.size()), found);
  CHECK(found == expected);
  // Places and `still` first, then five values of a, each followed by the same three of b.
  CHECK(diagram.nodes.size() == 3);
  CHECK(verify::diagram_text(diagram, *c.system) == R"(node 0 ROOT.b.n=-1 ROOT.b.n=0 ROOT.b.n=1
node 1 ROOT.a.n=-2&#0 ROOT.a.n=-1&#0 ROOT.a.n=0&#0 ROOT.a.n=1&#0 ROOT.a.n=2&#0
node 2 ROOT.a@S&ROOT.a.still=1&ROOT.b@S&ROOT.b.still=1&#1
lemma #2
)");
}

}  // namespace
