// Answers by structural invariants whether a reachable state may have given atoms in given modes. Invariants (traps,
// place invariants, state-machine components, as in prove_by_invariants.hpp) are found when a question needs them and
// stay for the next question.
//
// Sound but incomplete: "no" is a proof, "yes" is what the invariants leave open. Cost: one SAT call per question and
// per round of invariants.
#pragma once
#include <map>
#include <memory>
#include <vector>

#include "compiler/verify/net/net_encoding.hpp"
#include "compiler/verify/invariants/place_invariants.hpp"
#include "compiler/verify/invariants/state_machine_components.hpp"
#include "compiler/verify/invariants/traps.hpp"

namespace bip::verify {

class ModeFacts {
 public:
  /// The net is usable and outlives this. NoStep: states without a sure step are asked about, else all.
  ModeFacts(const Net& net, Encoded what, const CancellationToken& cancellation);

  /// Excludes a mode from all later questions.
  void exclude(u32 mode);
  /// Is there a state in which one mode of each set (sorted) is marked? No set: any state. Looks for invariants at most
  /// `rounds` times.
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
  std::unique_ptr<PlaceInvariantFinder> place_invariants_;
  std::unique_ptr<StateMachineComponentFinder> components_;
  std::map<std::vector<u32>, Lit> literals_;
  std::size_t invariants_ = 0;
};

}  // namespace bip::verify
