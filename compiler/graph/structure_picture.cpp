// Draws a scene that structure_layout.hpp has laid out. A box's coordinates are mapped to the picture's when it is
// drawn: moved, and mirrored if it is flipped.
#include <algorithm>

#include <fmt/format.h>

#include "compiler/graph/bundle.hpp"
#include "compiler/graph/picture.hpp"
#include "compiler/graph/scene.hpp"
#include "compiler/graph/structure_layout.hpp"

namespace bip::graph {
namespace {

constexpr double kMargin = 12, kSign = 4, kBehind = 4;

/// From a box's own coordinates to the picture's.
struct Frame {
  double x = 0, y = 0, height = 0;
  bool is_mirrored = false;

  [[nodiscard]] Point point(Point p) const { return {x + p.x, is_mirrored ? y + height - p.y : y + p.y}; }
  /// Upper edge of something that is so high.
  [[nodiscard]] double top(double at, double size) const { return is_mirrored ? y + height - at - size : y + at; }
};

class StructureDrawing {
 public:
  explicit StructureDrawing(const Scene& scene) : scene_(scene), placed_(lay_out(scene)) {}

  Picture run() {
    // Depth first without recursion: a box's group closes after those of its children.
    struct Open {
      u32 box;
      Frame frame;
      std::size_t next = 0;
    };
    std::vector<Open> open;
    const auto enter = [&](u32 box, double x, double y, bool is_mirrored) {
      open.push_back({box, {x, y, placed_[box].height, is_mirrored}});
      draw_box(box, open.back().frame);
    };
    enter(0, kMargin, kMargin, false);
    while (!open.empty()) {
      const u32 box = open.back().box;
      if (open.back().next == scene_.boxes[box].children.size()) {
        draw_nets(box, open.back().frame);
        shapes_.end_group();
        open.pop_back();
        continue;
      }
      const Frame frame = open.back().frame;
      const u32 child = scene_.boxes[box].children[open.back().next++];
      const PlacedBox& placed = placed_[child];
      enter(child, frame.x + placed.x, frame.top(placed.y, placed.height), frame.is_mirrored != placed.is_flipped);
    }
    return {shapes_.elements(), placed_[0].width + 2 * kMargin, placed_[0].height + 2 * kMargin};
  }

 private:
  void draw_box(u32 row, const Frame& frame) {
    const SceneBox& box = scene_.boxes[row];
    const bool is_open = box.kind == BoxKind::Compound;
    std::string attributes = fmt::format(" data-path=\"{}\"", escaped_markup(box.path));
    if (box.atom != kNoRow) attributes += fmt::format(" data-atom=\"{}\"", box.atom);
    if (box.compound != kNoRow) attributes += fmt::format(" data-compound=\"{}\"", box.compound);
    if (box.count > 1) attributes += fmt::format(" data-count=\"{}\"", box.count);
    shapes_.begin_group(is_open ? "compound" : box.kind == BoxKind::Closed ? "closed" : "atom", attributes);
    shapes_.title(box.path + " : " + box.type);
    is_open ? draw_open(row, frame) : draw_closed(row, frame);
  }

  void draw_open(u32 row, const Frame& frame) {
    const SceneBox& box = scene_.boxes[row];
    const PlacedBox& placed = placed_[row];
    shapes_.box(frame.x, frame.y, placed.width, placed.height, 8, "frame");
    const double baseline = frame.top(3, 16) + 12;
    shapes_.heading({frame.x + 10, baseline}, box.name, ": " + box.type, kTitleSize);
    for (std::size_t p = 0; p < box.ports.size(); ++p) {
      const Point at = frame.point({placed.tabs[p].x, 0});
      shapes_.box(at.x - kSign, frame.top(0, 2 * kSign), 2 * kSign, 2 * kSign, 1, "exit");
      shapes_.text({at.x + 6, frame.top(4, 12) + 10}, box.ports[p].name, kPortSize, Align::Left, "dim");
    }
    double y = placed.notes;
    for (const std::string& note : box.notes) {
      shapes_.text({frame.x + 10, frame.top(y, 14) + 11}, note, kNoteSize, Align::Left, "dim");
      y += 14;
    }
  }

  void draw_closed(u32 row, const Frame& frame) {
    const SceneBox& box = scene_.boxes[row];
    const PlacedBox& placed = placed_[row];
    const std::string colour = fmt::format("c{}", box.colour);
    if (box.count > 1)
      for (const double away : {2 * kBehind, kBehind})
        shapes_.box(frame.x + away, frame.y + (frame.is_mirrored ? -away : away), placed.width, placed.height, 5,
                    "behind " + colour);
    shapes_.box(frame.x, frame.y, placed.width, placed.height, 5, "frame " + colour);
    for (std::size_t p = 0; p < box.ports.size(); ++p) {
      const PortTab& tab = placed.tabs[p];
      const double top = frame.top(0, kTabHeight);
      shapes_.box(frame.x + tab.x + 1, top, tab.width - 2, kTabHeight, 3, "tab " + colour);
      shapes_.text({frame.x + tab.x + tab.width / 2, top + 11}, box.ports[p].name, kPortSize, Align::Middle, "");
    }
    const double inner = box.ports.empty() ? 4 : kTabHeight + 4, middle = frame.x + placed.width / 2;
    const double top = frame.top(inner, placed.height - inner);
    shapes_.text({middle, top + 13}, box.name, kTitleSize, Align::Middle, "bold");
    shapes_.text({middle, top + 27}, box.type, kTypeSize, Align::Middle, "dim");
  }

  void begin_net(const SceneNet& net) {
    const bool is_plain = net.kind == NetKind::Exit || net.kind == NetKind::Merged;
    std::string attributes;
    if (!net.path.empty()) attributes += fmt::format(" data-path=\"{}\"", escaped_markup(net.path));
    if (net.first != kNoRow) attributes += fmt::format(" data-connector=\"{}\" data-last=\"{}\"", net.first, net.last);
    if (!net.bundled.empty()) {
      std::string rows;
      for (const auto& [first, last] : net.bundled)
        rows += fmt::format("{}{}-{}", rows.empty() ? "" : " ", first, last);
      attributes += fmt::format(" data-bundled=\"{}\"", rows);
    }
    shapes_.begin_group(is_plain ? "net plain" : fmt::format("net w{}", net.colour), attributes);
  }

  /// All lines, then all names.
  void draw_nets(u32 row, const Frame& frame) {
    const SceneBox& box = scene_.boxes[row];
    for (std::size_t n = 0; n < box.nets.size(); ++n) {
      begin_net(box.nets[n]);
      if (!box.nets[n].details.empty())
        shapes_.title((box.nets[n].path.empty() ? "" : box.nets[n].path + "\n") + box.nets[n].details);
      draw_lines_of(box.nets[n], placed_[row].nets[n], frame);
      shapes_.end_group();
    }
    for (std::size_t n = 0; n < box.nets.size(); ++n) {
      const SceneNet& net = box.nets[n];
      const Point at = placed_[row].nets[n].name;
      if (net.name.empty()) continue;
      begin_net(net);
      shapes_.text({frame.x + at.x, frame.top(at.y - 9, 12) + 9}, net.name, kNameSize, Align::Left, "name");
      shapes_.end_group();
    }
  }
  void draw_lines_of(const SceneNet& net, const PlacedNet& placed, const Frame& frame) {
    std::string lines;
    for (const LinePart& line : placed.lines) {
      const Point from = frame.point(line.from), to = frame.point(line.to);
      if (from.x == to.x && from.y == to.y) continue;
      lines += fmt::format("M{} {}L{} {}", coordinate(from.x), coordinate(from.y), coordinate(to.x), coordinate(to.y));
    }
    if (!lines.empty()) shapes_.path(lines, "wire");
    for (const Point joint : placed.joints) shapes_.circle(frame.point(joint), 2, "mark");
    for (const PlacedNet::End& end : placed.ends) draw_sign(end, frame);
    if (net.kind == NetKind::Merged) {
      const Point at = frame.point({placed.name.x, placed.name.y + 4});
      shapes_.path(fmt::format("M{} {}l5 -5l5 5l-5 5Z", coordinate(at.x - 12), coordinate(at.y)), "mark");
    }
  }

  /// A triangle for a trigger, a dot for a synchron.
  void draw_sign(const PlacedNet::End& end, const Frame& frame) {
    const Point at = frame.point(end.at);
    const double away = end.is_downwards != frame.is_mirrored ? 1 : -1;
    if (end.is_trigger) {
      shapes_.path(fmt::format("M{} {}h10L{} {}Z", coordinate(at.x - 5), coordinate(at.y), coordinate(at.x),
                               coordinate(at.y + away * 9)),
                   "mark");
    } else {
      shapes_.circle({at.x, at.y + away * kSign}, 3.5, "mark");
    }
  }

  const Scene& scene_;
  std::vector<PlacedBox> placed_;
  Shapes shapes_;
};

}  // namespace

Picture structure_picture(const System& system, const PictureOptions& options) {
  Scene scene = build_scene(system, options);
  bundle_nets(scene, options.bundle);
  return StructureDrawing(scene).run();
}

}  // namespace bip::graph
