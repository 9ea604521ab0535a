// The discrete time Markov chain of a model under the policy `uniform`, and exact answers on it.
//
// Its states are the reachable stable states; a step is taken with the share of its candidate's weight. What is left of
// the runs of a simulation is only their number: for models without time these are the probabilities that `bipc
// simulate` estimates. For small models: every state is stored.
#pragma once
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/library/estimate.hpp"
#include "runtime/engine/path_query.hpp"

namespace bip::library {

struct MarkovChain {
  std::vector<std::uint64_t> first;  // by state, and one more: its steps in the two tables below
  std::vector<std::uint32_t> to;     // ascending within a state
  std::vector<double> share;         // a state without candidates repeats: one step to itself
  std::vector<std::uint8_t> is_end;  // by state: it has no candidates

  [[nodiscard]] std::uint32_t states() const { return static_cast<std::uint32_t>(is_end.size()); }
};
/// Conditions by state of a chain.
using StateSet = std::vector<std::uint8_t>;

/// Builds the chain; `sets[k][s]` says whether conditions[k] holds in state s. The initial state is 0. Fails for more
/// than `most_states`, if a step ends in a run-time error, or if one has a probability below kLeastProbability.
/// Requires an image without time and C++, with its code.
[[nodiscard]] Result<MarkovChain> build_chain(const rt::Image& image, rt::MaximalProgress progress,
                                              std::uint32_t most_states,
                                              const std::vector<std::function<bool(const rt::Core&)>>& conditions,
                                              std::vector<StateSet>& sets);

/// The probability from state 0 to reach a goal by states that stay: within `most_steps` steps, exact but for rounding;
/// else as an interval that contains it, of relative width kPrecision (interval iteration: S. Haddad, B. Monmege,
/// Reachability in MDPs, 2014; after states that surely or never reach a goal have been found in the graph). What is
/// possible with a probability below kLeastProbability is the interval from 0 to it.
inline constexpr double kPrecision = 1e-10;
/// Below it numbers have fewer digits, or are 0.
inline constexpr double kLeastProbability = std::numeric_limits<double>::min();
[[nodiscard]] Interval reach_probability(const MarkovChain& chain, const StateSet& stays, const StateSet& goal,
                                         std::uint64_t most_steps);

/// The expected number of steps from state 0 to the first goal; infinite if some run never reaches one. Iterated until
/// no state's value grows by more than the share kPrecision / 100.
[[nodiscard]] double expected_steps(const MarkovChain& chain, const StateSet& goal);

/// The chain in the language of PRISM: one variable for the state, and a label for each named set.
[[nodiscard]] std::string prism_text(const MarkovChain& chain, const std::string& title,
                                     const std::vector<std::string>& names, const std::vector<StateSet>& sets);

}  // namespace bip::library
