// Counterexample-guided refinement by structural invariants, for any bad state of a transition system: a bad state that
// the invariants so far allow is a candidate; traps, place invariants and state-machine components that exclude it
// refine the abstraction; repeat (E. Clarke, O. Grumberg, S. Jha, Y. Lu, H. Veith: Counterexample-Guided Abstraction
// Refinement, 2000, with invariants as the refinement).
#pragma once
#include <memory>

#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/portfolio/prove_by_invariants.hpp"

namespace bip::verify {

/// Adds to `proof.invariants` what excludes bad states. `assumed`: further clauses that hold in every reachable state.
/// True: no bad state is left, the property is proved. False: one is left that no such invariant excludes, or the time
/// is over.
[[nodiscard]] bool refine_invariants(const Net& net, TransitionSystem& system, const rt::Image& image, Signal bad,
                                     const std::vector<std::vector<Signal>>& assumed,
                                     const CancellationToken& cancellation, Proof& proof);
/// The same for one set of states after the other. All arguments must outlive it, and `proof.invariants` only grows.
class InvariantRefiner {
 public:
  InvariantRefiner(const Net& net, TransitionSystem& system, const rt::Image& image,
                   const CancellationToken& cancellation, Proof& proof);
  ~InvariantRefiner();
  InvariantRefiner(const InvariantRefiner&) = delete;
  InvariantRefiner& operator=(const InvariantRefiner&) = delete;
  /// Do invariants exclude all of these states? Those that are missing are added to the proof, also where one of the
  /// states is left.
  [[nodiscard]] bool exclude(Signal states);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};
/// Keeps the invariants that are in the unsatisfiable core of such a proof.
void minimize_invariants(const Net& net, TransitionSystem& system, const rt::Image& image, Signal bad,
                         const std::vector<std::vector<Signal>>& assumed, const CancellationToken& cancellation,
                         Proof& proof);

}  // namespace bip::verify
