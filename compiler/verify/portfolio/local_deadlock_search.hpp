// Local deadlocks, exactly: all stable states are visited, and with the graph of their steps in hand a component is
// stuck for ever in a state if it wants to move and no step that can still be taken from there, now or later, moves it.
//
// A state in which that can be seen at once (local_deadlock.hpp) ends the visit early. Which atoms can still move is a
// union over all that is reachable: one pass over the strongly connected components, which StrongComponents
// (compiler/analysis/graph_algorithms.hpp) closes in the right order. A step that ends in a run-time error counts as
// one that moves its participants. Cost: the visit's, and for each step one bit an atom; memory two bits an atom and
// state, and four bytes a step.
//
// Up to symmetry: states that differ by a permutation of equal components count once (runtime/explore/symmetry.hpp).
// Who can still move is then known of those components only that no permutation moves. So one of each group is never
// permuted: if any of the group waits for ever, then in the image of that run under a permutation this one does.
#pragma once
#include "compiler/verify/portfolio/search_bad_state.hpp"

namespace bip::verify {

struct LocalDeadlockResult {
  SearchResult search;                // Found: the way to the first such state that is known
  std::vector<u32> stuck;             // Found: rows of atoms
  std::vector<std::string> permuted;  // groups of equal components
};
/// Permute: of equal components those that wait for ever need not all be named in `stuck`.
enum class SymmetryUse : std::uint8_t { None, Permute };

/// Visits all states within the limits (`only_walk` is ignored) and returns a shortest path to a state with a local
/// deadlock. A path that is returned has been replayed. The image must have its code. Permute requires has_symmetry().
[[nodiscard]] LocalDeadlockResult find_local_deadlock(const Net& net, const rt::Image& image,
                                                      const SearchLimits& limits,
                                                      SymmetryUse symmetry = SymmetryUse::None);

}  // namespace bip::verify
