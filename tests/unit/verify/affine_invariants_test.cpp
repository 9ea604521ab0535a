// Equations between ints and places: found where code counts, not where it does not, with totals and bounds.
#include <catch2/catch.hpp>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/invariants/affine_invariants.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;

// Users are counted by a clerk; `leave` of the second model forgets every other time, `n = 0` of the third takes away
// what its guard says.
std::string model(const std::string& leave) {
  return R"(package p
  port type Signal()
  connector type Two(Signal a, Signal b)
    define a b
  end
  connector type One(Signal a)
    define a
  end
  atom type Clerk()
    data int n = 5
    data bool odd = false
    export port Signal enter(), leave(), reset()
    place S, T
    initial to S
    on enter from S to S do { n = n + 2; }
    )" + leave +
         R"(
  end
  atom type User()
    export port Signal enter(), leave()
    place OUT, IN
    initial to OUT
    on enter from OUT to IN
    on leave from IN to OUT
  end
  compound type Root()
    component Clerk c()
    component User u(), v()
    connector Two eu(u.enter, c.enter), ev(v.enter, c.enter), lu(u.leave, c.leave), lv(v.leave, c.leave)
    connector One r(c.reset)
  end
end
)";
}

verify::AffineInvariants facts_of(const std::string& leave, std::vector<std::string>& rows) {
  const gen::Compiled c = gen::compile_texts({model(leave)});
  REQUIRE(c.problem.empty());
  const verify::Net net = verify::build_net(*c.system);
  verify::TransitionSystem machine = verify::build_transition_system(*c.system, c.lowered->image);
  verify::AffineInvariants facts =
      verify::find_affine_invariants(net, machine, c.lowered->image, {}, verify::within_seconds(60));
  for (const verify::AffineEquation& one : facts.equations) rows.push_back(verify::equation_row(one, *c.system));
  return facts;
}

}  // namespace

TEST_CASE("what is counted at each step is equal to what is there") {
  std::vector<std::string> rows;
  const verify::AffineInvariants facts =
      facts_of("on leave from S to S do { if (odd) then n = n - 2; else n = n - 3; n = n + 1; fi odd = !odd; }", rows);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0] == "equation 5 ROOT.u@IN*-2 ROOT.v@IN*-2 ROOT.c.n*1");
  // 5 + 4 is enough, and the solver shows some such bound.
  REQUIRE(facts.bounds.size() == 1);
  CHECK(facts.bounds[0].high >= 9);
}

TEST_CASE("a count that is wrong every other time is no equation") {
  std::vector<std::string> rows;
  CHECK(facts_of("on leave from S to S do { if (odd) then n = n - 2; fi odd = !odd; }", rows).equations.empty());
}

TEST_CASE("a guard says how much an assignment takes away, but not after a comparison of another kind") {
  std::vector<std::string> rows, none;
  const char* const leave =
      "on leave from S to S do { n = n - 2; }\n    on reset from S to T provided (n == 9) do { n = 0; }";
  REQUIRE(facts_of(leave, rows).equations.size() == 1);
  CHECK(rows[0].find("ROOT.c@T*") != std::string::npos);
  CHECK(rows[0].find("9") != std::string::npos);
  CHECK(
      facts_of("on leave from S to S do { n = n - 2; }\n    on reset from S to T provided (n >= 9) do { n = 0; }", none)
          .equations.empty());
}

TEST_CASE("an assignment takes away what the variable is wherever the atom is at that place") {
  std::vector<std::string> rows, none;
  const std::string leave =
      "on leave from S to S do { n = n - 2; }\n    on reset from S to T provided (n == 9) do { n = 0; }\n    on reset "
      "from T to S do { n = 9; }";
  const verify::AffineInvariants facts = facts_of(leave, rows);
  REQUIRE(facts.equations.size() == 1);
  CHECK(rows[0].find("ROOT.c@T*9") != std::string::npos);
  REQUIRE(facts.places.size() == 1);
  CHECK(facts.places[0].value == 0);
  // Not if it may be something else there.
  CHECK(facts_of(leave + "\n    on enter from T to T do { n = n + 1; }", none).equations.empty());
  CHECK(facts_of("on leave from S to S do { n = n - 2; }\n    on reset from S to T do { n = n - 9; }\n    on reset "
                 "from T to S do { n = 9; }",
                 none)
            .places.empty());
}
