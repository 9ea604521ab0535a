// Proofs by counting: linear programs with known maxima, nets made by hand, and proofs that are changed and must not
// hold any more.
#include <catch2/catch.hpp>

#include <cmath>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/counting/exclude_all.hpp"
#include "compiler/verify/counting/simplex.hpp"
#include "runtime/explore/explore.hpp"
#include "tools/gen/compiled.hpp"

namespace bip::verify {

namespace {

// Tokens move from place 0 to 1 or 2, and back to 0 from 2 only if `returns`; who asks counts those that came to 1 (3,
// 4, 5: none, one, two).
CountedNet votes(u32 voters, bool returns) {
  CountedNet net;
  for (u32 place = 0; place < 6; ++place) net.places.push_back({place < 3 ? 0u : 1u, place});
  net.places_of_kind = {{0, 1, 2}, {3, 4, 5}};
  net.tokens = {voters, 0, 0, 1, 0, 0};
  net.transitions = {{{0, 3}, {1, 4}}, {{0, 4}, {1, 5}}, {{0}, {2}}};
  if (returns) net.transitions.push_back({{1}, {0}});
  return net;
}

// Two who need three votes each of five voters, who vote once.
const char* const kElection = R"(package p
  port type Signal()
  connector type Two(Signal a, Signal b) define a b end
  atom type Voter()
    export port Signal vote()
    place FREE, DONE
    initial to FREE
    on vote from FREE to DONE
  end
  atom type Candidate(int least)
    data int votes = 0
    export port Signal get()
    place ASKS, WON
    initial to ASKS
    on get from ASKS to ASKS provided (votes < least - 1) do { votes = votes + 1; }
    on get from ASKS to WON provided (votes == least - 1)
  end
  compound type Root()
    component Voter v[5]
    component Candidate c[2](LEAST)
    for i in 0..2 { for k in 0..5 connector Two give[i * 5 + k](c[i].get, v[k].vote) }
  end
end
)";

struct Election {
  gen::Compiled compiled;
  std::unique_ptr<interp::Interpreter> interpreter;
  std::unique_ptr<CountedNetBuilder> builder;
  std::vector<BadPlaces> bad;

  explicit Election(const std::string& least) {
    std::string text = kElection;
    text.replace(text.find("LEAST"), 5, least);
    compiled = gen::compile_texts({text});
    REQUIRE(compiled.problem.empty());
    interpreter = std::make_unique<interp::Interpreter>(*compiled.lowered);
    const rt::Image& image = compiled.lowered->image;
    Result<Property> property = parse_property("never c[0]@WON && c[1]@WON", *compiled.system);
    REQUIRE(property);
    InterchangeableGroups groups = rt::interchangeable_members(image, {});
    // The candidates are alike, too, but the property names them.
    std::erase_if(groups, [](const auto& group) { return group.size() != 5; });
    REQUIRE(groups.size() == 1);
    builder = std::make_unique<CountedNetBuilder>(image, groups, std::vector<rt::VariableId>());
    builder->build({});
    REQUIRE(builder->net().problem.empty());
    auto found = find_bad_places(*builder, *property, [&](const rt::Core& core) { return is_broken(*property, core); });
    REQUIRE(found);
    bad = std::move(*found);
  }
};

}  // namespace

TEST_CASE("simplex: a maximum with its multipliers") {
  // y0 <= 4, y0 + y1 <= 6, y0 + 3 y1 <= 12: 3 y0 + 2 y1 is largest at (4, 2).
  LinearProgram program;
  program.bounds = {4, 6, 12};
  program.columns = {{3, {{0, -1}, {1, -1}, {2, -1}}}, {2, {{1, -1}, {2, -3}}}};
  const SimplexResult result = maximise(program, {});
  REQUIRE(result.end == SimplexEnd::Optimal);
  CHECK(std::abs(result.value - 16) < 1e-4);
  CHECK(std::abs(result.multipliers[0] - 1) < 1e-9);
  CHECK(std::abs(result.multipliers[1] - 2) < 1e-9);
  CHECK(std::abs(result.multipliers[2]) < 1e-9);
  CHECK(std::abs(result.slack[2] - 2) < 1e-4);
}

TEST_CASE("simplex: what has no maximum, and what has no time, has a limit") {
  LinearProgram program;
  program.bounds = {1};
  program.columns = {{1, {{0, 1}}}};
  CHECK(maximise(program, {}).end == SimplexEnd::Limit);
  program.columns = {{1, {{0, -1}}}};
  CHECK(maximise(program, {}).end == SimplexEnd::Optimal);
  CHECK(maximise(program, within_seconds(0)).end == SimplexEnd::Limit);
}

TEST_CASE("counting: two votes need two voters") {
  const BadPlaces two{{{5}}};
  CHECK_FALSE(find_sub_invariant(votes(2, false), two, {}).proof);
  const CountedNet one = votes(1, false);
  const std::optional<SubInvariant> proof = find_sub_invariant(one, two, {}).proof;
  REQUIRE(proof);
  CHECK(excludes(one, two, *proof));
  // With more voters, or one who votes again, the same weights prove nothing.
  CHECK_FALSE(excludes(votes(2, false), two, *proof));
  CHECK_FALSE(excludes(votes(1, true), two, *proof));
  CHECK_FALSE(find_sub_invariant(votes(1, true), two, {}).proof);
  for (std::size_t place = 0; place < proof->weights.size(); ++place) {
    SubInvariant less = *proof;
    if (less.weights[place] == 0) continue;
    less.weights[place] = 0;
    CHECK_FALSE(excludes(one, two, less));
  }
}

TEST_CASE("counting: a trap that is not empty at first keeps a token") {
  // A key at 0 or 1, which step 2 -> 3 reads at 1 and only 0 -> 1 brings there; {0, 1} never loses it.
  CountedNet net;
  for (u32 place = 0; place < 4; ++place) net.places.push_back({place < 2 ? 0u : 1u, place});
  net.places_of_kind = {{0, 1}, {2, 3}};
  net.tokens = {1, 0, 1, 0};
  // Who is at 2 goes to 3 and takes the key away to 0, where it is already.
  net.transitions = {{{1, 2}, {1, 3}}};
  const BadPlaces bad{{{3}}};
  // The marking equation alone lets the step happen, as it takes nothing from 1.
  const std::optional<SubInvariant> found = find_sub_invariant(net, bad, {}).proof;
  REQUIRE(found);
  CHECK_FALSE(found->traps.empty());
  CHECK(excludes(net, bad, *found));
  SubInvariant without = *found;
  without.traps.clear();
  CHECK_FALSE(excludes(net, bad, without));
  SubInvariant unmarked = *found;
  unmarked.traps[0].places = {1};
  CHECK_FALSE(excludes(net, bad, unmarked));
  // With a way for the key it is no proof any more.
  net.transitions.push_back({{0}, {1}});
  CHECK_FALSE(excludes(net, bad, *found));
  CHECK_FALSE(find_sub_invariant(net, bad, {}).proof);
}

TEST_CASE("counting: two majorities, and two that are one vote short") {
  const Election three("3");
  // 2 places of the five voters, 3 + 1 local states of each candidate.
  CHECK(three.builder->net().places.size() == 10);
  CHECK(three.builder->net().tokens[three.builder->net().places_of_kind[0][0]] == 5);
  REQUIRE(three.bad.size() == 1);
  const std::optional<SubInvariant> proof = find_sub_invariant(three.builder->net(), three.bad[0], {}).proof;
  REQUIRE(proof);
  CHECK(excludes(three.builder->net(), three.bad[0], *proof));

  const Election two("2");
  REQUIRE(two.bad.size() == 1);
  CHECK_FALSE(find_sub_invariant(two.builder->net(), two.bad[0], {}).proof);
  CHECK_FALSE(exclude_all(*two.builder, two.bad, {}));
}

}  // namespace bip::verify
