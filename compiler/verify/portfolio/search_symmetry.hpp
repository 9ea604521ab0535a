// Symmetry in searches of the prover: which equal components may be permuted without changing the answer.
#pragma once
#include "compiler/verify/portfolio/question.hpp"
#include "runtime/explore/explore.hpp"

namespace bip::verify {

/// Makes the exploration identify states up to permutations of equal components under which the question stays the
/// same, if there are such components and they are found with little work. `options` has the unread cells already;
/// `question` must outlive it. Sound for deadlocks, errors and properties of states.
void use_symmetry(const Question& question, const rt::Image& image, rt::ExploreOptions& options);
/// Would use_symmetry have an effect?
[[nodiscard]] bool has_symmetry(const Question& question, const rt::Image& image);

/// What restricts the permutations for any question: the work of finding them.
[[nodiscard]] rt::SymmetryLimits symmetry_limits();
/// Are there components that may be permuted for a question about no component?
[[nodiscard]] bool has_symmetry(const rt::Image& image);

}  // namespace bip::verify
