// Proofs that none of several kinds of bad markings is reachable, by case distinction.
//
// The marking equation lets a component be in several places at once, in fractions. Where it does so in a bad marking
// that it cannot exclude, the component is in one of two sets of places: where a place is marked or not, or where a
// variable has a value or another one. Each case is asked by itself, and so on (branch and bound: Land, Doig 1960).
#pragma once
#include <optional>
#include <vector>

#include "compiler/verify/counting/sub_invariant.hpp"

namespace bip::verify {

struct ExcludedPlaces {
  BadPlaces places;
  SubInvariant proof;
};
/// Returns proofs of cases that cover all of `bad`; nothing: one of them has none, there are too many, or the time is
/// over.
[[nodiscard]] std::optional<std::vector<ExcludedPlaces>> exclude_all(CountedNetBuilder& builder,
                                                                     const std::vector<BadPlaces>& bad,
                                                                     const CancellationToken& cancellation);

}  // namespace bip::verify
