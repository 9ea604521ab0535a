// Splits conflict sets that are too large for one coordinator.
//
// An *occasion* is a state of an atom (its place, with its history where that tells more) in which interactions of the
// set can take it, or of an atom that is looked at, any state. An occasion with several interactions is contended.
// - The coordinator of an interaction is the first of the nodes at which its contended atoms are at home.
// - On an occasion whose interactions have one coordinator the atom is offered to that node, as in sets that are not
//   split. On others it is *shared*: it is offered at its home, and locked there for one attempt after the other.
// So all locks of an attempt are at its coordinator or at later nodes, and a chain of locks in the order of nodes
// visits each of them once (node.hpp). A set of which no occasion is shared is not split: it comes
// apart.
//
// Not split are sets whose atoms show C++ objects, which cannot be sent, sets in which a guard or an `up` may fault
// between two steps, which no attempt may evaluate for long, and sets at home on one node. Linear in the
// ports of the split sets' interactions and in what they look at, but for the logarithms of sorting.
#pragma once
#include <utility>
#include <vector>

#include "runtime/distributed/distribution.hpp"

namespace bip::rt {

/// Of a distribution whose sets have one coordinator each: splits those of more than Placement::split_above
/// interactions.
void split_sets(const Tables& tables, const PriorityTables& rules, Distribution& distribution);

/// Why a set that is too large keeps one coordinator: the model has time, its components are at home on one node, a
/// guard, an `up` or a rule may end in a run-time error between two steps, its components show C++ objects, or no
/// component of it would be offered to several coordinators.
enum class WholeSet : std::uint8_t { Time, OneNode, Fault, Objects, NothingShared };
/// Returns the sets of more than `split_above` interactions that were not split, in ascending order, and why. Takes the
/// number of the placement as it was given, since models with time are distributed without it.
[[nodiscard]] std::vector<std::pair<u32, WholeSet>> find_whole_sets(const Tables& tables, const PriorityTables& rules,
                                                                    const Distribution& distribution, u32 split_above);

}  // namespace bip::rt
