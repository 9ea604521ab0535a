// Localization reduction on the circuit: IC3 follows the bits of a few atoms, and all others are inputs that may have,
// in each state anew, any value that the invariants allow. An over-approximation, so a proof is one of the whole
// system, whose lemmas are about those atoms only. A counterexample may rest on values that cannot be: if invariants
// exclude one of its states they are added, otherwise atoms whose values it needs are followed as well.
//
// R. Kurshan: Computer-Aided Verification of Coordinating Processes (1994), section 8.1. E. Clarke, O. Grumberg, S.
// Jha, Y. Lu, H. Veith: Counterexample-Guided Abstraction Refinement (2000). Departure: which atoms are added is read
// from the unsat cores of lifting, without a concrete replay of the counterexample. Cost: IC3 begins anew with each
// round.
#pragma once
#include "compiler/verify/symbolic/ic3.hpp"

namespace bip::verify {

/// Adds invariants to the problem that exclude all of these states. False: there are none, or none that are new.
using ExcludeStates = std::function<bool(Signal states)>;

struct LocalizedAnswer {
  // Safe: a proof of the whole system. Reached: no unfollowed bit is known to matter (lifting may have failed), so this
  // is no counterexample of the whole system.
  Ic3Answer answer;
  std::vector<u32> followed_atoms;  // ascending
  u32 rounds = 0;
};

/// Starts with the atoms on whose state the bad states depend. `atom_of_port`: by port instance. Stopped: out of time,
/// or more than `max_atoms` atoms would be followed.
[[nodiscard]] LocalizedAnswer run_localized_ic3(Ic3Problem& problem, TransitionSystem& system,
                                                const std::vector<u32>& atom_of_port, std::size_t max_atoms,
                                                const ExcludeStates& exclude);

}  // namespace bip::verify
