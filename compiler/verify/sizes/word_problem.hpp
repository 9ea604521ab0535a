// From the description of a compound for every size to words: the modes of its components, taken from an instance of
// the least size that has all zones, and its interactions.
#pragma once
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/sizes/sized_compound.hpp"
#include "compiler/verify/sizes/word_proof.hpp"

namespace bip::verify {

/// Returns whether the instance of size `size` has the components and connectors that the description says.
[[nodiscard]] bool is_described_instance(const SizedCompound& sized, const System& system, std::int64_t size);

/// Returns the words' problem, or what is not followed. `net`: of the instance of the description's least size; the
/// problem refers to it.
[[nodiscard]] Result<WordProblem> make_word_problem(const SizedCompound& sized, const Model& model,
                                                    const CompoundType& type, const Net& net);

/// "n = 5: phil[0]@THINKS, …" of a candidate.
[[nodiscard]] std::string candidate_text(const SizedCompound& sized, const Net& net, const WordProblem& problem,
                                         const WordAnswer& answer, const std::string& size_name);

}  // namespace bip::verify
