// How a graph of states grows, and what it keeps of each state, where a property of runs or of branching time is
// decided on it; internal to compiler/verify/liveness and compiler/verify/branching.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/verify/property/expression.hpp"
#include "compiler/verify/property/property.hpp"
#include "runtime/explore/state_graph.hpp"

namespace bip::verify {

/// States of the first round; each further one has so many times more. Rounds so cost a constant factor.
inline constexpr std::uint64_t kStatesOfFirstRound = 4096, kGrowthOfRounds = 8, kMostStates = 0xffffffffu;
inline constexpr std::size_t kMegabyte = 1'000'000;

/// Predicate k of the graph is condition k; the conditions must outlive it.
[[nodiscard]] inline std::vector<rt::GraphPredicate> predicates_of(const std::vector<Property>& conditions) {
  std::vector<rt::GraphPredicate> predicates;
  for (const Property& condition : conditions) {
    rt::GraphPredicate& predicate = predicates.emplace_back();
    predicate.holds = [&condition](const rt::Core& core) { return is_true(condition, core); };
    predicate.connectors = connectors_of(condition);
    predicate.atoms = atoms_of(condition);
  }
  return predicates;
}

}  // namespace bip::verify
