// What matters in a counterexample: the steps without which the run would not end so, ordered by cause, and the step
// that decided it.
//
// Both replay runs with the core, so what they return has been taken; both have a bound on the steps that they replay,
// not on time, so their answers do not depend on the machine. The image must have its code, and no time and no FFI
// data.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/verify/portfolio/search_bad_state.hpp"
#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

/// Returns the numbers of the candidates of a run to the goal whose steps are a part of the given one's. Loops are cut
/// out, and steps that share no component with the goal's past if it is reached without them; then blocks of steps are
/// left out as long as the goal is reached (ddmin: Zeller, Hildebrandt 2002), down to single ones; within the bound no
/// step can be left out any more, of a run of at most 64 steps no block of them. A step then follows what it depends on
/// (a step before it of one of its atoms) as closely as it can; if some can be left out in this order, all begins anew.
/// `choices` must reach the goal. Cost: at most about 1,000,000 steps of the core.
[[nodiscard]] std::vector<std::uint64_t> relevant_steps(const rt::Image& image, const SearchGoal& goal,
                                                        const std::vector<std::uint64_t>& choices,
                                                        const CancellationToken& token);

struct DecidingStep {
  std::size_t step = 0;  // before this step of the run the goal could be avoided, after it not
  std::string way_out;   // the first step of such a run, as traces write it; empty: none avoids the goal
};
/// Returns the last step before which the goal could be avoided, by a run to another end or for ever; nothing if the
/// run has no choices, or the bounds are too small to tell. A run for ever counts only if atoms of the given run move
/// in it again and again, or can again and again not move: steps of others beside them are no way out. If a run can end
/// with an error that is not the goal, that none avoids it is not claimed. Cost: a search of at most 20,000 states for
/// each of log(choices) states of the run.
[[nodiscard]] std::optional<DecidingStep> deciding_step(const rt::Image& image, const SearchGoal& goal,
                                                        const std::vector<std::uint64_t>& choices,
                                                        const CancellationToken& token);

}  // namespace bip::verify
