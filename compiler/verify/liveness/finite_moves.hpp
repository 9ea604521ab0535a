// Proves a property of runs from what components do finitely often. In a run that violates it, say one in which a
// request waits for ever, most components come to rest one after the other: each draws one more ticket, passes, and
// then waits, too. How often a port moves in such a run is a question about its atom and those of the property alone,
// where k-liveness of the whole would count the moves of all of them together.
//
// A port is finite if each run that violates the property has finitely many steps in which it takes part. Proved for
// one port after the other by k-liveness on a part of the circuit, each with those that are known to be finite, in the
// order in which that succeeds: a lexicographic ranking whose components are counters of rounds. What is left to prove
// is the property of the runs in which no finite port moves any more. Of a system all of whose steps have one, these
// are the runs that have ended. Sound and incomplete, as k_liveness.hpp. Cost: at most four searches by IC3 for each
// port and finite port of its part.
//
// Ranking by components: Z. Manna, A. Pnueli, Completing the Temporal Picture (1991), chain rule; B. Cook, A. Podelski,
// A. Rybalchenko, Proving Thread Termination (2007).
#pragma once
#include "compiler/verify/liveness/k_liveness.hpp"

namespace bip::verify {

/// Of more ports, so many searches take longer than the whole.
inline constexpr std::size_t kMostMovingPorts = 400;

/// As prove_by_k_liveness. `finite_ports` of a proof is above 0. Unknown, too, if more than kMostMovingPorts take part
/// in steps.
[[nodiscard]] KLivenessProof prove_by_finite_moves(const Formula& formula, const System& system, const rt::Image& image,
                                                   const RunCircuit& circuit, const KLivenessOptions& options);

}  // namespace bip::verify
