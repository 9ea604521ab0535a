// The transition system in the AIGER format, for other model checkers (A. Biere, K. Heljanko, S. Wieringa: AIGER 1.9
// and Beyond, 2011): one latch per state bit, one input per step and free input, one output that is 1 in a bad state.
#pragma once
#include <string>

#include "compiler/verify/symbolic/transition_system.hpp"

namespace bip::verify {

/// Returns the ASCII form ("aag") with a symbol table. The output can become 1 if and only if the transition system
/// reaches a state in which `bad` holds: where no step or more than one is chosen, or the chosen one cannot be taken,
/// the latches keep their values, so every assignment of the inputs is allowed. Latches are numbered after inputs,
/// and-gates in topological order after latches, as the binary form wants it. A latch with the initial value 1 holds
/// the negated bit (AIGER 1.0 has only the initial value 0); one without a known initial value is its own reset (1.9).
/// Adds nodes to the system's AIG, which must not be full. Linear.
[[nodiscard]] std::string aiger_text(TransitionSystem& transition_system, Signal bad, const System& system);

}  // namespace bip::verify
