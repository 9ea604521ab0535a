// A run through an accepting and fair component: the fewest steps to it, then a cycle in it.
//
// The cycle is found by breadth-first searches, each to the nearest edge that brings something which is still missing:
// a mark, a step that fairness asks for, a state where such a step is impossible; the last one back to where the cycle
// began. So it is short, but not the shortest. Cost: an edge of the component for each search, at most one search for
// each mark and each unit of fairness.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/verify/liveness/components.hpp"

namespace bip::verify {

struct LassoStep {
  std::uint32_t label = rt::kNone;
  std::uint32_t state = 0;  // of the graph, after the step
};
/// No cycle: the run ends, and its last state repeats.
struct Lasso {
  std::vector<LassoStep> stem, cycle;
};

/// Requires that `found` is a component of the product that was found with this fairness.
[[nodiscard]] Lasso find_lasso(const Product& product, const AcceptingComponent& found, const Fairness& fairness);

}  // namespace bip::verify
