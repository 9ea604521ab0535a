// Edges of a layered layout (layers.hpp) as arrows. Internal to graph/.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "compiler/graph/layers.hpp"

namespace bip::graph {

/// How wide the sides of a node are on which edges meet it, and how far they are inside of its room. No width: edges
/// are left as they are.
struct EdgeRoom {
  double width = 0, inset = 0;
};
/// Edges that meet a node on the same side get places beside each other, in the order of where they come from.
void spread_edge_ends(std::vector<LayerEdge>& edges, const std::function<EdgeRoom(std::uint32_t node)>& room_of);

enum class ArrowHead : std::uint8_t { None, AtEnd };
void draw_layer_arrow(Shapes& shapes, const LayerEdge& edge, Point shift, ArrowHead head);

}  // namespace bip::graph
