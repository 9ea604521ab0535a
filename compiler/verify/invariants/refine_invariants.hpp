// Traps and one-token invariants on demand for any bad state of the machine, not only for deadlocks: a bad state that
// what is known allows gives a candidate, and that the invariants that exclude it.
#pragma once
#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/portfolio/prove_by_invariants.hpp"

namespace bip::verify {

/// `known`: clauses that hold in every reachable state, beside the structure's.
/// Adds to `proof.invariants` what excludes bad states. True: none is left, the property is proved. False: one is left
/// that no such invariant excludes, or the time is over.
[[nodiscard]] bool refine_invariants(const Net& net, TransitionSystem& machine, const rt::Image& image, Signal bad,
                                     const std::vector<std::vector<Signal>>& known,
                                     const CancellationToken& cancellation, Proof& proof);
/// Leaves the invariants that such a proof needs.
void minimize_invariants(const Net& net, TransitionSystem& machine, const rt::Image& image, Signal bad,
                         const std::vector<std::vector<Signal>>& known, const CancellationToken& cancellation,
                         Proof& proof);

}  // namespace bip::verify
