// "The weights of what is marked add up to this" as a decision diagram: a level an atom, a node for each sum of the
// atoms so far that can still become the total. Sums that cannot are not there, so an invariant over few tokens stays
// small.
//
// Cost: atoms times different sums, for each the atom's modes that have a weight. Past kMaxEdges there is no diagram.
// After N. Een, N. Sorensson: Translating Pseudo-Boolean Constraints into SAT (2006).
#pragma once
#include "compiler/verify/symbolic/aig.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/solver/solver.hpp"
#include "compiler/verify/invariants/traps.hpp"

namespace bip::verify {

struct WeightedSum {
  static constexpr std::size_t kMaxEdges = 200'000;
  struct Edge {
    u32 node = 0, next = 0;  // kNoRow: the sum can't become the total any more
    u32 mode = 0;            // kNoRow: any but those
    u32 first_but = 0, but = 0;
  };
  u32 nodes = 0;            // 0 is the beginning, the last one the end: sum and total agree
  std::vector<Edge> edges;  // in the order of levels
  std::vector<u32> buts;    // modes
};

/// `is_reachable` by mode. False: too large.
[[nodiscard]] bool build_weighted_sum(const Net& net, const TokenInvariant& invariant,
                                      const std::vector<std::uint8_t>& is_reachable, WeightedSum& sum);
/// `literals` and `signals` by mode; `on`: the clauses count only where it is true, 0: everywhere.
void add_weighted_sum(const WeightedSum& sum, const std::vector<Lit>& literals, Solver& solver, Lit on = 0);
[[nodiscard]] Signal weighted_sum_signal(const WeightedSum& sum, const std::vector<Signal>& signals, Aig& aig);

}  // namespace bip::verify
