// A run that shows why a formula of branching time holds in the initial state, or does not, as far as one run can
// (Clarke, Grumberg, McMillan, Zhao 1995): where some run decides, it is followed; where all runs do, the state and the
// part of the formula are named. Ways to a state are the shortest (breadth-first); a cycle is short, but not the
// shortest. Cost: at most three searches of the graph for each operator on the way.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/verify/branching/label_states.hpp"
#include "compiler/verify/liveness/lasso.hpp"

namespace bip::verify {

/// Each run from the state has what the node says of one, or none has.
struct ClaimOfAllRuns {
  std::size_t position = 0;  // after so many steps
  std::uint32_t state = 0;
  std::uint32_t node = 0;
};
struct ExplainingRun {
  std::vector<LassoStep> steps;
  std::size_t cycle = 0;  // the steps from here on repeat
  bool repeats = false;   // it goes on for ever: in the cycle, or without one in its last state
  std::vector<ClaimOfAllRuns> claims;
};

/// `labels` are those that the verdict was read off, which is `holds`: Bound::Surely for true.
[[nodiscard]] ExplainingRun explain(const BranchingFormula& formula, const rt::StateGraph& graph,
                                    const std::vector<StateSet>& labels, bool holds);

/// How many states can be reached from a state, itself among them; `is_whole`: all of them have steps.
struct StatesFrom {
  std::uint32_t count = 0;
  bool is_whole = true;
};
[[nodiscard]] StatesFrom states_from(const rt::StateGraph& graph, std::uint32_t state);

}  // namespace bip::verify
