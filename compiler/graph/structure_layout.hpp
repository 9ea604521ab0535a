// Where the boxes and the lines of a scene are.
//
// Each open box is laid out by itself, inside out. Its children stand in rows; the ports of a row face a channel, in
// which each net has one horizontal line (a track) and a vertical line from each of its ports to it. Rows face each
// other in pairs, so that a channel serves two of them; a net with ports at several channels has a vertical line beside
// the rows. So no line crosses a box, and no two labels meet, by construction. The order of the children keeps the
// tracks short (barycentres, Sugiyama et al. 1981); tracks are packed by the left-edge algorithm (Hashimoto and
// Stevens 1971).
//
// Cost per box: linear in its nets' ends per round of ordering, O(n log n) for tracks except for the search of a free
// one.
#pragma once
#include <vector>

#include "compiler/graph/scene.hpp"
#include "compiler/graph/shapes.hpp"

namespace bip::graph {

inline constexpr double kTitleSize = 12, kTypeSize = 11, kPortSize = 10, kNameSize = 10, kNoteSize = 10;
inline constexpr double kTabHeight = 15;

/// A port's room on its box, from the box's left edge.
struct PortTab {
  double x = 0, width = 0;
};
struct LinePart {
  Point from, to;
};
/// What a net looks like in the box around it; coordinates are the box's.
struct PlacedNet {
  std::vector<LinePart> lines;
  /// Where it meets a port or a net that it binds: the point, and whether the line leaves it downwards.
  struct End {
    Point at;
    bool is_trigger = false, is_downwards = false;
  };
  std::vector<End> ends;
  std::vector<Point> joints;
  Point name;  // left end of the baseline
};
/// A box as it is when its ports are at the top. A flipped one is its mirror image.
struct PlacedBox {
  double width = 0, height = 0;
  double x = 0, y = 0;  // in the box around it
  bool is_flipped = false;
  std::vector<PortTab> tabs;  // by port
  std::vector<PlacedNet> nets;
  double notes = 0;  // y of the first note's room
};

/// By box of the scene.
[[nodiscard]] std::vector<PlacedBox> lay_out(const Scene& scene);

}  // namespace bip::graph
