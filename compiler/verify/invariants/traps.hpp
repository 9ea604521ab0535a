// Traps: sets of modes that no step can empty. If one holds a token at first, it always holds one.
//
// From a candidate: the largest trap within its unmarked modes (ModeReachability backward, linear), and from that,
// around each initial mode in it, a small trap, grown by repairing what would leave it and then shrunk place by place.
// A set is a trap if in every step in which a port moves out of the set, another port moves into it or stays in it; all
// choices of a trigger group and all moves of a port count, so the check is by structure, never by listing
// interactions. After Bensalem, Bozga, Nguyen, Sifakis: Compositional Verification for Component-Based Systems and
// Application (2010); lazily: candidates first, traps second (compiler/docs/verification.md).
#pragma once
#include <compare>
#include <vector>

#include "compiler/verify/net/net.hpp"
#include "compiler/verify/net/mode_reachability.hpp"

namespace bip::verify {

enum class InvariantKind : std::uint8_t { Trap, OneToken, Sum };
/// Trap: at least one of the modes is marked. OneToken: exactly one. Sum: the weights of those that are marked add up
/// to the total.
struct TokenInvariant {
  InvariantKind kind = InvariantKind::Trap;
  std::vector<u32> modes;                  // sorted
  std::vector<std::int64_t> weights = {};  // Sum: by row of modes, not 0; less than 0 only of atoms with many modes
  std::int64_t total = 1;                  // Sum
  friend auto operator<=>(const TokenInvariant&, const TokenInvariant&) = default;
};

[[nodiscard]] inline std::int64_t weight_of(const TokenInvariant& invariant, std::size_t row) {
  return invariant.weights.empty() ? 1 : invariant.weights[row];
}

class TrapFinder {
 public:
  TrapFinder(const Net& net, const ModeReachability& reachable);

  /// Traps that are marked at first and not in the candidate (by mode: 1 if marked). Empty: there is none.
  [[nodiscard]] std::vector<TokenInvariant> find(const std::vector<std::uint8_t>& marked);

  /// Those that hold; candidates may come from anywhere, their modes are sorted and of the net.
  [[nodiscard]] std::vector<TokenInvariant> those_that_hold(const std::vector<TokenInvariant>& candidates);
  /// Does every step keep the number of tokens in the set, and is it one at first? Decided by structure.
  [[nodiscard]] bool is_state_machine_component(const std::vector<u32>& modes) {
    return keeps_sum({InvariantKind::OneToken, modes});
  }
  /// Is one of these modes marked at first, and can no step empty them?
  [[nodiscard]] bool holds_trap(const std::vector<u32>& modes);
  /// Does every step keep the sum of the weights (1, where there are none), and is it the total at first?
  [[nodiscard]] bool keeps_sum(const TokenInvariant& invariant);

 private:
  static constexpr std::size_t kMaxGrown = 4000, kMaxShrunk = 64;
  static constexpr std::size_t kBatch = 1u << 20;
  static constexpr u32 kMaxDepth = 64;
  static constexpr std::uint64_t kImpossible = 1u << 30;

  [[nodiscard]] bool is_possible(u32 port, u32 from_mode) const {
    return reachable_.is_on(from_mode) && reachable_.in_context(port);
  }
  [[nodiscard]] bool may_put_nothing(u32 node, u32 depth) const;
  [[nodiscard]] bool others_may_put_nothing(u32 parent, const Edge& edge_up, u32 child) const;
  [[nodiscard]] bool is_in_bad_context(u32 node, u32 depth) const;
  std::uint64_t make_putter(u32 node, bool apply, u32 depth);
  std::uint64_t protect(u32 node, bool apply, u32 depth);
  bool grow(u32 start);
  [[nodiscard]] bool leaves_set(u32 mode) const;
  bool shrink(u32 start, std::size_t drop);
  [[nodiscard]] bool is_trap() const;
  void put(u32 mode);
  void clear();
  [[nodiscard]] std::int64_t delta(u32 node, u32 depth) const;

  const Net& net_;
  const ModeReachability& reachable_;
  std::vector<std::uint8_t> in_large_;  // by mode: in the largest trap
  std::vector<std::uint8_t> in_set_;    // by mode: in the set at hand
  std::vector<u32> set_;
  std::vector<std::int64_t> weight_;   // by mode: in the sum at hand
  std::vector<std::uint8_t> is_seen_;  // by node, scratch
};

}  // namespace bip::verify
