// Local lemmas: clauses of two literals about one component, or about two that take part in a step together. They
// prove protocols whose argument is about neighbours; their number is linear in the steps.
//
// Candidates are all such cubes of a place or of a bit of data. Sampled states refute most of those that do not hold,
// questions about few components others (local_houdini.hpp), Houdini (houdini.hpp) decides about the rest. After the
// candidate invariants of M. Ernst, J. Cockrell, W. Griswold, D. Notkin (Dynamically Discovering Likely Program
// Invariants to Support Program Evolution, 2001), confined to neighbours as the local proofs of K. Namjoshi (Symmetry
// and Completeness in the Analysis of Parameterized Systems, 2007).
#pragma once
#include "compiler/verify/symbolic/ic3.hpp"

namespace bip {
struct System;
}

namespace bip::verify {

/// States of a system, 64 in a word: by bit of the transition system its values in them.
struct SampledStates {
  std::vector<std::vector<std::uint64_t>> values;
};

/// Returns the cubes of one or two literals that no sampled state satisfies; none that a smaller one of them subsumes.
/// `is_possible`, by literal: some state may satisfy it though no sampled one does, so it is no cube by itself.
/// Steps of more than a few components make no neighbours. Nothing if there are more than `most`, or no time is left.
/// Cost: for each two neighbours, the product of their bits by the words of a bit.
[[nodiscard]] std::vector<Cube> find_local_candidates(const TransitionSystem& machine,
                                                      const std::vector<u32>& atom_of_port, const SampledStates& states,
                                                      const std::vector<std::uint8_t>& is_possible, std::size_t most,
                                                      const CancellationToken& cancellation);

/// Returns the cubes grouped by what they say, whichever components of the same types they are about.
[[nodiscard]] std::vector<std::vector<Cube>> group_by_shape(const std::vector<Cube>& cubes,
                                                            const TransitionSystem& machine, const System& system);

}  // namespace bip::verify
