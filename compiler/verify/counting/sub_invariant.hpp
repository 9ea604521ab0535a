// Weights of the places of a counted net whose sum no transition raises (a place sub-invariant), and which a bad
// marking exceeds.
//
// Bad is a marking with a token in each of k sets of places. By the marking equation, m = tokens + sum of the changes
// by transitions, no transition less often than 0 times. If the largest sum of tokens in the sets that satisfies it,
// with no place below 0, is less than k, no bad marking is reachable, and the dual solution of this linear program is
// the proof (Farkas 1902): integer weights with
//
//   sum over `to` of weight <= sum over `from` of weight      for each transition,
//   weight[p] >= (scale if p is in a set) + (factor of each trap that p is in),
//   sum over p of weight[p] * tokens[p] - (factors of the traps) < k * scale.
//
// Where the largest sum is k, traps that the solution empties, though they have a token initially, are added: a trap
// keeps one. J. Esparza, R. Ledesma-Garza, R. Majumdar, P. Meyer, F. Niksic: An SMT-based Approach to Coverability
// Analysis (CAV 2014). Sound and incomplete: the marking equation forgets the order of transitions. The weights are
// found in floating point, rounded, and count only if the inequalities hold in integers.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "compiler/verify/counting/bad_places.hpp"

namespace bip::verify {

struct SubInvariant {
  struct WeightedTrap {
    std::vector<u32> places;  // sorted
    std::int64_t factor = 0;
  };
  std::int64_t scale = 1;
  std::vector<std::int64_t> weights;  // by place
  std::vector<WeightedTrap> traps;    // of factor > 0
};

struct SubInvariantSearch {
  std::optional<SubInvariant> proof;  // absent: there is none of this form, or the time is over
  std::vector<double> open;  // by place: tokens of a bad marking that satisfies the marking equation, in fractions
};
/// Searches a proof that no marking of `bad` is reachable.
[[nodiscard]] SubInvariantSearch find_sub_invariant(const CountedNet& net, const BadPlaces& bad,
                                                    const CancellationToken& cancellation);
/// Do all inequalities hold, and is each trap one that has a token initially? In integers, from the net alone. Linear
/// in the net and the traps.
[[nodiscard]] bool excludes(const CountedNet& net, const BadPlaces& bad, const SubInvariant& proof);

}  // namespace bip::verify
