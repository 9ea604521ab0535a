// Checks token invariants of all kinds by structure, wherever they come from: a proof cache, another net, a search.
#pragma once
#include "compiler/verify/invariants/place_invariant_checker.hpp"
#include "compiler/verify/invariants/traps.hpp"

namespace bip::verify {

class TokenInvariantChecker {
 public:
  TokenInvariantChecker(const Net& net, const ModeReachability& reachable)
      : traps_(net, reachable), place_invariants_(net, reachable) {}

  /// Does the invariant hold initially, and does every step keep it? Its modes are sorted and of the net.
  [[nodiscard]] bool holds(const TokenInvariant& invariant) {
    return invariant.kind == InvariantKind::Trap ? traps_.holds(invariant.modes) : place_invariants_.holds(invariant);
  }
  /// Returns the candidates that hold, in their order.
  [[nodiscard]] std::vector<TokenInvariant> those_that_hold(const std::vector<TokenInvariant>& candidates) {
    std::vector<TokenInvariant> result;
    for (const TokenInvariant& candidate : candidates) {
      if (holds(candidate)) result.push_back(candidate);
    }
    return result;
  }

 private:
  TrapFinder traps_;
  PlaceInvariantChecker place_invariants_;
};

}  // namespace bip::verify
