// Homes for atoms to which a placement gives none: where the steps of several nodes are fewest.
//
// A hypergraph is cut: its vertices are atoms, its edges interactions, weighted by how often they were taken; the cost
// of an edge is its weight for each node beyond the first. There are eight first cuts (of 20,000 vertices or more,
// two): one is grown breadth first from the atoms that have a home; the others one piece after the other, each around
// its homes, by the vertex that cuts least (graph growing: G. Karypis, V. Kumar, "A fast and high quality multilevel
// scheme for partitioning irregular graphs", SIAM J. Sci. Comput. 20(1), 1998, section 4.2), from starts in different
// parts of the model. Of each cut single vertices move, the one that gains most first, each once in a pass, and the
// best state of the pass is kept (C. M. Fiduccia, R. M. Mattheyses, "A linear-time heuristic for improving network
// partitions", DAC 1982), until a pass gains nothing. The cheapest is taken.
//
// Loads are bounded on both sides. No node gets more than its share and a tenth (one more at least), unless the
// placement says so. No node gets less than half of the level to which free atoms fill the nodes, the emptiest first
// (one at least, if they suffice for all): between grown and improved, nodes below it get the vertices that cost least,
// and no later move goes below it. Only atoms that stay together can leave a node with less.
//
// The same input gives the same homes. A pass costs the edges of each vertex that moves or is beside one that moves.
#pragma once
#include <vector>

#include "runtime/distributed/distribution.hpp"

namespace bip::rt {

/// Gives homes to the atoms that have none (kNone). counts: by interaction, how often it was taken; empty: all alike.
/// Atoms whose C++ objects may not cross stay together.
void place_free_atoms(const Tables& tables, const PriorityTables& rules, const std::vector<u64>& counts,
                      Placement& placement);

}  // namespace bip::rt
