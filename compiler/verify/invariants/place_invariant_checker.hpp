// Checks place invariants by structure: does every step keep the weighted sum of the marked modes?
//
// Decided bottom up on the connectors' trees, never by listing interactions: by how much does a choice below a node
// change the sum? If two choices below one node differ in that, the invariant is refused. Sound but incomplete: a
// refused sum may still be constant. Independent of how an invariant was found. Cost: linear in the ports of the
// invariant's atoms and what stands above them.
#pragma once
#include "compiler/verify/net/mode_reachability.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/invariants/token_invariant.hpp"

namespace bip::verify {

class PlaceInvariantChecker {
 public:
  PlaceInvariantChecker(const Net& net, const ModeReachability& reachable);

  /// Does every step keep the sum of the weights (1, where there are none), and is it the total initially?
  [[nodiscard]] bool holds(const TokenInvariant& invariant);
  /// Does every step keep the number of tokens in the set, and is it one initially?
  [[nodiscard]] bool is_state_machine_component(const std::vector<u32>& modes) {
    return holds({InvariantKind::OneToken, modes});
  }

 private:
  static constexpr u32 kMaxDepth = 64;

  [[nodiscard]] std::int64_t change(u32 node, u32 depth) const;
  [[nodiscard]] bool holds_initially(const TokenInvariant& invariant) const;
  [[nodiscard]] bool steps_above_keep_sum(std::vector<u32> ports);

  const Net& net_;
  const ModeReachability& reachable_;
  std::vector<std::int64_t> weight_;      // by mode: in the invariant that is checked
  std::vector<std::uint8_t> is_visited_;  // by node, scratch
};

}  // namespace bip::verify
