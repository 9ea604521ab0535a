// Local deadlock: a component that wants to move and never can again, whatever the others do, seen from one state
// alone.
//
// The greatest set of which each member needs, for each step that it could take, another member that does not offer
// what it would have to. Members do not move, so that stays so. Guards of connectors count as true and others may offer
// anything one day: what is said to be stuck is, and more may be (local_deadlock_search.hpp knows them all). Cost:
// linear in the net, a few times over. After P. Attie, S. Bensalem, M. Bozga, M. Jaber, J. Sifakis, F. Zaraket: Global
// and Local Deadlock Freedom in BIP (2018).
#pragma once
#include "compiler/verify/net/net.hpp"
#include "runtime/core/core.hpp"

namespace bip::verify {

/// Returns the rows of atoms that are in a local deadlock in the core's state, sorted. Sound but incomplete: an atom
/// that is left out may still be in one. Requires a net whose modes are few enough. Cost: linear in the net per round,
/// at most one round per atom.
[[nodiscard]] std::vector<u32> locally_deadlocked_atoms(const Net& net, const rt::Core& core);

}  // namespace bip::verify
