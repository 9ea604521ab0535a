// See layer_arrows.hpp.
#include "compiler/graph/layer_arrows.hpp"

#include <algorithm>
#include <cstdint>
#include <map>

#include <fmt/format.h>

#include "runtime/include/bip/assert.hpp"

namespace bip::graph {
namespace {

std::string curve_of(const std::vector<Point>& points, Point shift) {
  const auto shown = [&](Point p) { return Point{p.x + shift.x, p.y + shift.y}; };
  const auto pair = [](Point p) { return coordinate(p.x) + " " + coordinate(p.y); };
  std::string out = "M" + pair(shown(points[0]));
  for (std::size_t k = 1; k < points.size(); ++k) {
    const Point p = shown(points[k]), before = shown(points[k - 1]);
    if (k % 2 == 1) {
      if (p.y != before.y || p.x != before.x) out += "L" + pair(p);
    } else {
      const double middle = (before.y + p.y) / 2;
      out += "C" + coordinate(before.x) + " " + coordinate(middle) + " " + coordinate(p.x) + " " + coordinate(middle) +
             " " + pair(p);
    }
  }
  return out;
}

}  // namespace

void spread_edge_ends(std::vector<LayerEdge>& edges, const std::function<EdgeRoom(std::uint32_t node)>& room_of) {
  enum class EdgeEnd : std::uint8_t { Start, Target };
  struct End {
    std::uint32_t edge;
    EdgeEnd which;
    double toward;
  };
  std::map<std::pair<std::uint32_t, bool>, std::vector<End>> sides;
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    const std::vector<Point>& points = edges[e].points;
    const auto add = [&](std::uint32_t node, EdgeEnd which, Point end, Point next, Point far) {
      if (room_of(node).width <= 0) return;
      sides[{node, end.y < next.y || (end.y == next.y && end.y < far.y)}].push_back({e, which, far.x});
    };
    const std::size_t n = points.size();
    BIP_ASSERT(n >= 4 && n % 2 == 0, "edge {} has {} points", e, n);
    add(edges[e].from, EdgeEnd::Start, points[0], points[1], points[2]);
    add(edges[e].to, EdgeEnd::Target, points[n - 1], points[n - 2], points[n - 3]);
  }
  for (auto& [where, ends] : sides) {
    std::stable_sort(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.toward < b.toward; });
    const EdgeRoom room = room_of(where.first);
    const double count = static_cast<double>(ends.size());
    const double step = count < 2 ? 0 : std::min(16.0, room.width / (count - 1));
    for (std::size_t k = 0; k < ends.size(); ++k) {
      std::vector<Point>& points = edges[ends[k].edge].points;
      const double away = (static_cast<double>(k) - (count - 1) / 2) * step;
      const std::size_t last = points.size() - 1;
      const bool is_start = ends[k].which == EdgeEnd::Start;
      points[is_start ? 0 : last].x += away;
      points[is_start ? 1 : last - 1].x += away;
      points[is_start ? 0 : last].y += where.second ? -room.inset : room.inset;
    }
  }
}

void draw_layer_arrow(Shapes& shapes, const LayerEdge& edge, Point shift, ArrowHead head) {
  const std::vector<Point>& points = edge.points;
  shapes.path(curve_of(points, shift), "arrow");
  if (head == ArrowHead::None) return;
  const Point end = points.back();
  Point before = points[points.size() - 2];
  if (before.y == end.y) before = points[points.size() - 3];
  const double down = before.y < end.y ? 1 : -1;
  shapes.path(
      fmt::format("M{} {}l-4 {}h8Z", coordinate(end.x + shift.x), coordinate(end.y + shift.y), coordinate(-8 * down)),
      "head");
}

}  // namespace bip::graph
