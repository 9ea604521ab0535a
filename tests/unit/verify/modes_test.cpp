// The modes of an atom: markings with the data that guards depend on, internal transitions folded in, data dropped
// where there would be too many.
#include <catch2/catch.hpp>

#include <set>

#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;

/// One atom with a connector on each of its ports `go` and `on`.
std::string one_atom(const std::string& body) {
  return R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Atom(int start)
    export port Signal go(), flip()
    )" + body +
         R"(
  end
  compound type Root()
    component Atom c(3)
    connector One g(c.go), f(c.flip)
  end
end
)";
}
std::set<std::string> mode_names(const HandMadeNet& made) {
  std::set<std::string> names;
  for (u32 mode = 0; mode < made.net.mode_count(); ++mode) names.insert(made.net.mode_name(mode));
  return names;
}

}  // namespace

TEST_CASE("modes: places with the values that guards read") {
  const HandMadeNet made(one_atom(R"(data bool lit = false
    data int ignored = 0
    place S, T
    initial to S
    on flip from S to S do { lit = !lit; ignored = ignored + 1; }
    on go from S to T provided (lit))"));
  CHECK(mode_names(made) == std::set<std::string>{"c@S (lit = false)", "c@S (lit = true)", "c@T (lit = true)"});
  const ModeClass& modes = made.net.class_at(0);
  CHECK(modes.initial.size() == 1);
  CHECK(made.net.mode_name(modes.initial[0]) == "c@S (lit = false)");
  // `flip` in both modes of S, `go` only where its guard is true.
  CHECK(modes.moves[0].size() == 1);
  CHECK(modes.moves[1].size() == 2);
  CHECK(made.reachable.is_on(made.mode("c@T (lit = true)")));
}

TEST_CASE("modes: internal transitions are folded in, their places are no modes") {
  const HandMadeNet made(one_atom(R"(place S, PASSING, T
    initial to S
    on go from S to PASSING
    internal from PASSING to T
    on flip from T to S)"));
  CHECK(mode_names(made) == std::set<std::string>{"c@S", "c@T"});
}

TEST_CASE("modes: data with too many values is not followed") {
  const std::string counter = R"(data int n = 0
    place S, T
    initial to S
    on flip from S to S provided (n < LIMIT) do { n = n + 1; }
    on go from S to T provided (n == LIMIT))";
  const auto with_limit = [&](const std::string& limit) {
    std::string text = counter;
    for (std::size_t k = text.find("LIMIT"); k != std::string::npos; k = text.find("LIMIT")) text.replace(k, 5, limit);
    return one_atom(text);
  };
  const HandMadeNet few(with_limit("9"));
  CHECK(few.net.mode_count() == 11);
  const HandMadeNet many(with_limit(std::to_string(kMaxModesWithData)));
  CHECK(mode_names(many) == std::set<std::string>{"c@S", "c@T"});
  // Then a guard over it is never sure.
  const std::vector<std::uint8_t>& sure = many.net.class_at(0).is_sure[0];
  CHECK(std::count(sure.begin(), sure.end(), 1) == 0);
}

TEST_CASE("modes: what never changes is a constant") {
  const HandMadeNet made(one_atom(R"(data int same = 4
    data int other = 4
    place S
    initial to S
    on go from S to S provided (same + start > 6)
    on flip from S to S provided (other < 9) do { other = other + 1; })"));
  const std::vector<AbstractValue> constants = constants_of(made.net.class_at(0));
  REQUIRE(constants.size() == 3);
  int known_values = 0;
  for (const AbstractValue& value : constants) {
    if (!value.is_known) continue;
    CHECK((value.value == 3 || value.value == 4));
    ++known_values;
  }
  CHECK(known_values == 2);
}

}  // namespace bip::verify
