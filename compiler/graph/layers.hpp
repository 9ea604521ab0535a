// Layered layout of a directed graph (Sugiyama, Tagawa and Toda 1981): nodes in layers from top to bottom, so that most
// edges lead down; few crossings; edges straight where they can be.
//
// A node reaches `left` and `right` of its anchor, where edges meet it; a label is a node of its own. So nothing
// overlaps, by construction. Cost: layers are a topological order; ordering and placement are a fixed number of sweeps,
// each O(e log e).
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "compiler/graph/shapes.hpp"

namespace bip::graph {

struct LayerNode {
  double left = 0, right = 0, height = 0;
  double x = 0, y = 0;  // result: the anchor, and the upper edge
};
struct LayerEdge {
  std::uint32_t from = 0, to = 0;
  std::vector<Point> points;  // result, from `from` to `to`: pairs of points with a straight line or a curve between
};
struct LayerSize {
  double width = 0, height = 0;
};

/// Places nodes and edges in [0, width] x [0, height]. Loops at one node are not allowed. Nodes that come first in the
/// list come first in the picture.
LayerSize lay_out_layers(std::vector<LayerNode>& nodes, std::vector<LayerEdge>& edges);

/// By edge (from, to): does it close a cycle in a depth-first search from the roots, then from all other nodes, in
/// their order? Without these edges the graph has no cycle. Linear.
[[nodiscard]] std::vector<bool> edges_leading_back(std::size_t nodes,
                                                   const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges,
                                                   std::vector<std::uint32_t> roots = {});

}  // namespace bip::graph
