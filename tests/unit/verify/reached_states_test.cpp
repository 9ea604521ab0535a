// The rows of a set of states: one each, sorted, with what differs from the row before.
#include <catch2/catch.hpp>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/portfolio/search_bad_state.hpp"
#include "compiler/verify/evidence/reached_states.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;

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

TEST_CASE("the rows of what a search has reached") {
  const gen::Compiled c = gen::compile_texts({kTwoCounters});
  REQUIRE(c.problem.empty());
  const interp::Interpreter interpreter(*c.lowered);
  const verify::Net net = verify::build_net(*c.system);
  verify::StateCollector states(*c.system, c.lowered->image, 10'000), few(*c.system, c.lowered->image, 250);
  REQUIRE(states.is_listable());
  const verify::SearchLimits limits{.cancellation = verify::within_seconds(20),
                                    .report = {},
                                    .visit = [&](const rt::State& state) { states.add(state), few.add(state); }};
  const verify::SearchResult all = verify::search(net, c.lowered->image, {}, {}, limits);
  REQUIRE(all.end == verify::SearchEnd::Exhausted);
  CHECK(all.states == 15);
  std::string expected = "state ROOT.a@S ROOT.a.n=-2 ROOT.a.still=1 ROOT.b@S ROOT.b.n=-1 ROOT.b.still=1\n";
  for (int a = -2; a <= 2; ++a) {
    if (a != -2) expected += "state ROOT.a.n=" + std::to_string(a) + " ROOT.b.n=-1\n";
    expected += "state ROOT.b.n=0\nstate ROOT.b.n=1\n";
  }
  CHECK(states.rows() == expected);
  // 15 states of 6 values take 360 bytes.
  CHECK(few.rows().empty());
}

}  // namespace
