// What structure says of sets of modes: can there be a reachable state in which these atoms are in these modes?
// Invariants are found when a question needs them (traps, linear, one-token: as in prove_by_invariants.hpp), and stay
// for the next question.
//
// "No" is a proof, "yes" is only what is left open. Cost: a SAT call a question, and one more an invariant.
#pragma once
#include <map>
#include <memory>
#include <vector>

#include "compiler/verify/net/net_encoding.hpp"
#include "compiler/verify/invariants/place_invariants.hpp"
#include "compiler/verify/invariants/state_machine_components.hpp"

namespace bip::verify {

class ModeFacts {
 public:
  /// The net is usable and outlives this. NoStep: states without a sure step are asked about, else all.
  ModeFacts(const Net& net, Encoded what, const CancellationToken& cancellation);

  /// Not in this mode, from now on.
  void exclude(u32 mode);
  /// Of each set (sorted) one mode is marked; no set: any state. `rounds`: at most so many times invariants are looked
  /// for.
  [[nodiscard]] bool may_be(const std::vector<std::vector<u32>>& sets, u32 rounds);
  [[nodiscard]] std::size_t invariants() const { return invariants_; }

 private:
  bool add_all(std::vector<TokenInvariant> found);
  [[nodiscard]] Lit one_of(const std::vector<u32>& modes);

  const Net& net_;
  CancellationToken cancellation_;
  ModeReachability reachable_;
  std::unique_ptr<Encoding> encoding_;
  std::unique_ptr<TrapFinder> traps_;
  std::unique_ptr<PlaceInvariantFinder> sums_;
  std::unique_ptr<StateMachineComponentFinder> one_tokens_;
  std::map<std::vector<u32>, Lit> literals_;
  std::size_t invariants_ = 0;
};

}  // namespace bip::verify
