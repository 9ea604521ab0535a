// Decides a property of runs on the graph of all reachable states: is there a fair run that violates it?
//
// The automaton of the negated formula runs beside the system (product.hpp); a strong component with an accepting and
// fair cycle is a violation (components.hpp); of an invariant that looks back, a finite run (bad_prefix.hpp). The graph
// grows in rounds, so that a violation near the initial state is found without the rest. A violating run is taken by a
// core from the initial state, the formula is evaluated on it anew, without the automaton, and its fairness is checked
// by the core's candidates before it is reported.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compiler/verify/property/fairness.hpp"
#include "compiler/verify/portfolio/question.hpp"
#include "compiler/verify/property/formula.hpp"
#include "compiler/verify/solver/cancellation.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::verify {

struct LivenessOptions {
  Fairness fairness;
  std::size_t megabytes = 2048;
  CancellationToken cancellation;
  std::vector<rt::VariableId> unread_cells;  // rt::ExploreOptions
  /// Of a property that holds: called with each reachable state, which then are visited though the formula be true of
  /// any run.
  std::function<void(const rt::Core&)> add_state;
  Report report;
};
/// Why a run that repeats is fair to a thing with a name.
struct FairTurn {
  enum class Why : std::uint8_t { Happens, Impossible, NeverPossible } why = Why::Happens;
  std::size_t step = 0;  // Happens: the first one that repeats; Impossible: the one before which it is not possible
};
struct LivenessResult {
  Outcome outcome = Outcome::Unknown;
  std::string reason;                              // Unknown
  bool is_out_of_time = false;                     // Unknown: with more time it may be decided
  std::uint64_t states = 0, steps = 0, nodes = 0;  // of the graph so far, of the product
  std::uint32_t automaton_states = 0;
  bool has_errors = false;              // a step of the graph ends in a run-time error
  std::vector<std::uint64_t> choices;   // Violated: numbers of candidates, each among those of its state
  std::size_t cycle = 0;                // the choices from here on repeat; none: the run ends there
  bool is_prefix = false;               // Violated: whatever follows; nothing repeats
  bool has_ended = false;               // is_prefix: but the last state, for the run has ended
  std::vector<FairTurn> turns;          // Violated, with a cycle: by term of the fairness with a name
  std::optional<Fairness> holds_under;  // Violated: it holds if runs are fair in this sense
};

/// Decides the formula for the runs of an image that has its code, without time, C++ and random numbers and without a
/// fault in the initialization.
[[nodiscard]] LivenessResult decide_liveness(const Formula& formula, const rt::Image& image,
                                             const LivenessOptions& options);

}  // namespace bip::verify
