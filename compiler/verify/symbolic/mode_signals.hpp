// What the structure knows, in the transition system's terms: each atom is in a reachable mode, traps and one-token
// invariants hold. Also the check that the ranges of data, which the transition system's bits rest on, are kept by
// every step.
#pragma once
#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/portfolio/prove_by_invariants.hpp"

namespace bip::verify {

/// A signal a mode. A state may fit several modes of a class, where values are unknown; the atom is in one of them all
/// the same. Then the modes are inputs: `clauses` say that it is exactly one, and one that fits.
struct ModeSignals {
  std::vector<Signal> modes;  // kFalse: not reachable
  std::vector<std::vector<Signal>> clauses;
};
[[nodiscard]] ModeSignals mode_signals(const Net& net, const Proof& proof, TransitionSystem& transition_system,
                                       const rt::Image& image);
/// The same, and the proof's invariants.
[[nodiscard]] std::vector<std::vector<Signal>> mode_clauses(const Net& net, const Proof& proof,
                                                            TransitionSystem& transition_system,
                                                            const rt::Image& image);
[[nodiscard]] bool ranges_hold(const TransitionSystem& transition_system, const CancellationToken& cancellation);

}  // namespace bip::verify
