// What is left of a counterexample: only the steps that it needs, however many others came before them.
#include <catch2/catch.hpp>

#include <string>
#include <utility>
#include <vector>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/evidence/relevant_steps.hpp"
#include "compiler/verify/portfolio/question.hpp"
#include "compiler/verify/property/property.hpp"
#include "runtime/core/core.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;

// Rooms in a row. A door joins two neighbours that are shut, and both are open until each of them has done.
std::string house(int rooms, const std::string& rule) {
  const std::string count = std::to_string(rooms);
  return R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  connector type Two(Signal a, Signal b)
    define a b
  end
  atom type Room()
    export port Signal left(), right(), done()
    place SHUT, OPEN
    initial to SHUT
    on left from SHUT to OPEN
    on right from SHUT to OPEN
    on done from OPEN to SHUT
  end
  compound type Root()
    component Room room[)" +
         count + "]()\n    for i in 0.." + count + " connector One done[i](room[i].done)\n    for i in 1.." + count +
         " connector Two door[i - 1](room[i - 1].right, room[i].left)\n" + rule + "\n  end\nend\n";
}

Property property_of(const HandMadeNet& made, const std::string& text) {
  Result<Property> property = parse_property(text, *made.compiled.system);
  REQUIRE(property);
  return std::move(*property);
}

std::vector<std::uint64_t> relevant(const HandMadeNet& made, const std::string& property,
                                    const std::vector<std::uint64_t>& choices) {
  const interp::Interpreter interpreter(*made.compiled.lowered);
  Question question;
  question.what = QuestionKind::State;
  question.property = property_of(made, property);
  return relevant_steps(made.compiled.lowered->image, goal_of(question), choices, {});
}

// The first run of pseudo-random choices that reaches the property's bad state.
std::vector<std::uint64_t> long_run(const HandMadeNet& made, const std::string& property) {
  const interp::Interpreter interpreter(*made.compiled.lowered);
  const Property bad = property_of(made, property);
  rt::Core core(made.compiled.lowered->image);
  REQUIRE(core.initialize());
  std::vector<std::uint64_t> choices;
  for (std::uint64_t seed = 1; !is_broken(bad, core); seed = seed * 6364136223846793005U + 1442695040888963407U) {
    REQUIRE(choices.size() < 100'000);
    choices.push_back((seed >> 33) % core.candidate_count());
    REQUIRE(core.fire(choices.back()));
  }
  return choices;
}

}  // namespace

TEST_CASE("of thousands of steps of others none is left") {
  const HandMadeNet made(house(400, ""));
  const std::string property = "never room[7]@OPEN && room[300]@OPEN && room[301]@OPEN";
  const std::vector<std::uint64_t> choices = long_run(made, property);
  CHECK(choices.size() > 300);
  CHECK(relevant(made, property, choices).size() == 2);
}

TEST_CASE("steps of others stay if a priority makes them matter") {
  // The first door waits until rooms 3 and 4 are not both shut.
  const HandMadeNet made(house(40, "    priority p door[0]:* < door[3]:*"));
  const std::string property = "never room[0]@OPEN";
  CHECK(relevant(made, property, long_run(made, property)).size() == 2);
}

}  // namespace bip::verify
