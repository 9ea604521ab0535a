// Traps: sets of modes that no step can empty. A trap that is marked initially stays marked for ever.
//
// Found from a candidate marking, never enumerated. The largest trap among the candidate's unmarked modes is a linear
// fixpoint (ModeReachability backward): drop each mode that some step can leave without putting a token into the set.
// If it is marked initially, the candidate is unreachable. From it, around each initial mode, a small trap is grown by
// repairing the steps that would leave the set, then shrunk mode by mode.
//
// A set is a trap if in every step in which a port moves out of the set another port moves into it or stays in it. All
// choices of a trigger group and all moves of a port count, so the check follows the connectors' trees and never lists
// interactions.
//
// J. Desel, J. Esparza: Free Choice Petri Nets (1995), on siphons and traps. J. Esparza, S. Melzer: Verification of
// Safety Properties Using Integer Programming (2000), traps from candidates. S. Bensalem, M. Bozga, T.-H. Nguyen, J.
// Sifakis: Compositional Verification for Component-Based Systems and Application (2010), section 3, interaction
// invariants; theirs enumerates all minimal traps.
#pragma once
#include <vector>

#include "compiler/verify/net/net.hpp"
#include "compiler/verify/net/mode_reachability.hpp"
#include "compiler/verify/invariants/place_invariant_checker.hpp"
#include "compiler/verify/invariants/token_invariant.hpp"

namespace bip::verify {

class TrapFinder {
 public:
  TrapFinder(const Net& net, const ModeReachability& reachable);

  /// Returns traps that are marked initially and not in the candidate (by mode: 1 if marked); empty: there is none. A
  /// trap with a constant number of tokens is returned as OneToken. One call gives traps for all parts of the
  /// candidate.
  [[nodiscard]] std::vector<TokenInvariant> find(const std::vector<std::uint8_t>& marked);

  /// Is one of these modes marked initially, and can no step empty them? Independent of how the set was found.
  [[nodiscard]] bool holds(const std::vector<u32>& modes);

 private:
  static constexpr std::size_t kMaxGrown = 4000, kMaxShrunk = 64;
  static constexpr std::size_t kMaxTrapsPerCall = 1u << 20;
  static constexpr u32 kMaxDepth = 64;
  static constexpr std::uint64_t kImpossible = 1u << 30;

  [[nodiscard]] bool is_possible(u32 port, u32 from_mode) const {
    return reachable_.is_on(from_mode) && reachable_.in_context(port);
  }
  // The set that is checked, grown or shrunk.
  void insert(u32 mode);
  void clear();
  // Which steps leave the set?
  [[nodiscard]] bool may_put_nothing(u32 node, u32 depth) const;
  [[nodiscard]] bool siblings_may_put_nothing(u32 parent, const Edge& edge_up, u32 child) const;
  [[nodiscard]] bool rest_of_step_may_put_nothing(u32 node, u32 depth) const;
  [[nodiscard]] bool can_be_left(u32 mode) const;
  [[nodiscard]] bool is_trap() const;
  [[nodiscard]] bool is_marked_initially() const;
  // From a candidate to a small trap.
  void compute_largest_trap(const std::vector<std::uint8_t>& marked);
  enum class Repair : std::uint8_t { Estimate, Apply };
  std::uint64_t make_node_put(u32 node, Repair repair, u32 depth);
  std::uint64_t make_rest_of_step_put(u32 node, Repair repair, u32 depth);
  bool grow(u32 start);
  bool shrink(u32 start, std::size_t drop);
  void shrink_all(u32 start);

  const Net& net_;
  const ModeReachability& reachable_;
  PlaceInvariantChecker place_invariants_;
  std::vector<std::uint8_t> in_largest_;  // by mode: in the largest trap of the candidate
  std::vector<std::uint8_t> in_set_;      // by mode
  std::vector<u32> set_;                  // in the order of insertion
};

}  // namespace bip::verify
