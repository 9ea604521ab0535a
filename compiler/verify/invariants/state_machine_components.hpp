// One-token invariants by SAT, on demand: a set of modes that holds exactly one token because every step takes at most
// one from it and puts as many. Looked for in a candidate that marks two modes of such a set, which traps cannot
// exclude.
//
// The search's formula is built when first asked for, linear in the net; what it finds is checked again by structure.
#pragma once
#include <memory>

#include "compiler/verify/solver/cancellation.hpp"
#include "compiler/verify/solver/solver.hpp"
#include "compiler/verify/invariants/traps.hpp"

namespace bip::verify {

/// Sets that one search asks the solver for at most.
inline constexpr std::size_t kComponentBatch = 16;

class StateMachineComponentFinder {
 public:
  static constexpr std::size_t kMostModes = 40'000;
  StateMachineComponentFinder(const Net& net, const ModeReachability& reachable) : net_(net), reachable_(reachable) {}
  /// Sets of which the candidate marks at least two modes, at most `count`; none in nets of more modes than kMostModes.
  [[nodiscard]] std::vector<TokenInvariant> find(TrapFinder& checker, const std::vector<std::uint8_t>& marked,
                                                 std::size_t count, const CancellationToken& cancellation);

 private:
  struct Effect {
    Lit plus = 0, minus = 0;
    bool is_dead = false;
  };
  void build();
  [[nodiscard]] Effect effect_of(u32 node);

  const Net& net_;
  const ModeReachability& reachable_;
  std::unique_ptr<Solver> solver_;
  std::vector<Lit> in_set_, first_, second_;  // by mode; 0: not reachable
  std::vector<Effect> effects_;               // by node
};

}  // namespace bip::verify
