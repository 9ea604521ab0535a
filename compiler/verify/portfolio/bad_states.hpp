// A question, and what is known of data, as signals of a transition system.
#pragma once
#include "compiler/verify/invariants/affine_invariants.hpp"
#include "compiler/verify/portfolio/question.hpp"

namespace bip::verify {

/// Returns the signal of the states that a question asks about. Not of local deadlocks and of runs.
[[nodiscard]] Signal bad_states(const Question& question, TransitionSystem& machine, const rt::Image& image);
[[nodiscard]] std::vector<std::vector<Signal>> affine_clauses(const AffineInvariants& affine, TransitionSystem& machine,
                                                              const rt::Image& image);

}  // namespace bip::verify
