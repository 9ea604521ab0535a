// Houdini with blocks of steps: what is inductive does not depend on how the steps are divided among solvers.
#include <catch2/catch.hpp>

#include "compiler/verify/invariants/houdini.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;
using test::lock_and_users;

// All cubes of one literal or two, over the places of all automata.
std::vector<Cube> small_cubes(const TransitionSystem& system) {
  std::vector<u32> literals;
  for (u32 bit = 0; bit < system.bits.size(); ++bit) literals.insert(literals.end(), {2 * bit, 2 * bit + 1});
  std::vector<Cube> cubes;
  for (std::size_t first = 0; first < literals.size(); ++first) {
    cubes.push_back({literals[first]});
    for (std::size_t second = first + 1; second < literals.size(); ++second) {
      if (cube_bit(literals[first]) != cube_bit(literals[second])) cubes.push_back({literals[first], literals[second]});
    }
  }
  return cubes;
}

}  // namespace

TEST_CASE("Houdini: blocks of steps leave the same lemmas as all steps at once") {
  const HandMadeNet made(lock_and_users());
  TransitionSystem system = build_transition_system(*made.compiled.system, made.compiled.lowered->image);
  REQUIRE(system.unsupported.empty());
  REQUIRE(system.steps.size() >= 4);
  Ic3Problem problem;
  problem.system = &system;
  problem.bad = system.aig.make_and(system.marks[1][1], system.marks[2][1]);
  const std::vector<Cube> candidates = small_cubes(system);
  const InductiveLemmas whole = houdini(problem, candidates);
  CHECK(whole.is_enough);
  CHECK(whole.lemmas.size() > 1);
  CHECK(whole.lemmas.size() < candidates.size());
  for (const std::size_t steps : {1, 2, 3}) {
    const InductiveLemmas found = houdini(problem, candidates, steps);
    CHECK(found.lemmas == whole.lemmas);
    CHECK(found.is_enough);
  }
}

TEST_CASE("Houdini: a block of steps that change none of the candidates keeps them, and another one refutes them") {
  const HandMadeNet made(lock_and_users());
  TransitionSystem system = build_transition_system(*made.compiled.system, made.compiled.lowered->image);
  Ic3Problem problem;
  problem.system = &system;
  problem.bad = kFalse;
  // "The first user is never in": a step of the first user breaks it, none of the second one does.
  const std::vector<u32> in_first = [&] {
    std::vector<u32> bits;
    for (u32 bit = 0; bit < system.bits.size(); ++bit) {
      if (system.bits[bit].now == system.marks[1][1]) bits.push_back(bit);
    }
    return bits;
  }();
  REQUIRE(in_first.size() == 1);
  for (const std::size_t steps : {1, 2, 1000}) CHECK(houdini(problem, {{2 * in_first[0] + 1}}, steps).lemmas.empty());
}

}  // namespace bip::verify
