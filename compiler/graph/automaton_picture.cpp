// Draws the automaton or Petri net of an atom type: places, and per transition its port, its guard and its action
// beside the line. Transitions between the same places share a line. Layout: layers.hpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "compiler/graph/code_text.hpp"
#include "compiler/graph/dot.hpp"
#include "compiler/graph/label_lines.hpp"
#include "compiler/graph/layer_arrows.hpp"
#include "compiler/graph/layers.hpp"
#include "compiler/graph/picture.hpp"
#include "compiler/source/utf8.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::graph {
namespace {

constexpr double kText = 10, kLine = 12, kPlaceHeight = 28, kSheetPad = 14, kLoop = 24, kBar = 14;

class AutomatonDrawing {
 public:
  AutomatonDrawing(const System& system, AtomTypeId id)
      : code_(system.code), type_(system.atom_types[id]), names_(names_of(type_)) {}

  Picture run() {
    make_nodes();
    const LayerSize size = lay_out_layers(nodes_, edges_);
    restore_edges();
    spread_ends();
    const double head = draw_heading();
    shift_ = {kSheetPad, head};
    for (std::size_t k = 0; k < labels_.size(); ++k) draw_transition(k);
    draw_initial();
    for (std::size_t p = 0; p < type_.places.size(); ++p) draw_place(p);
    Picture out;
    out.width = std::max(size.width, heading_width_) + 2 * kSheetPad;
    out.height = head + size.height + kSheetPad;
    Shapes sheet;
    sheet.begin_group("automaton", fmt::format(" data-type=\"{}\"", escaped_markup(type_.name)));
    sheet.box(0, 0, out.width, out.height, 8, "sheet");
    out.elements = sheet.elements() + shapes_.elements() + "</g>\n";
    return out;
  }

 private:
  using Row = std::uint32_t;
  /// Transitions with the same places on both sides.
  struct Label {
    std::vector<Row> transitions, from, to;
    std::vector<LabelLine> lines;
    Row node = 0;
    std::vector<Row> edges;
    bool is_internal = true, is_back = false;
    [[nodiscard]] bool is_loop() const { return from.size() == 1 && from == to; }
    [[nodiscard]] bool is_bar() const { return from.size() > 1 || to.size() > 1; }
    [[nodiscard]] double width() const { return width_of(lines, kText); }
    [[nodiscard]] double height() const { return kLine * static_cast<double>(lines.size()) + 4; }
  };

  [[nodiscard]] double place_width(std::size_t p) const {
    return std::max(40.0, std::ceil(text_width(type_.places[p], 11)) + 24);
  }

  void make_nodes() {
    std::map<std::pair<std::vector<Row>, std::vector<Row>>, std::size_t> of_places;
    for (Row t = 0; t < type_.transitions.size(); ++t) {
      const Transition& row = type_.transitions[t];
      const auto [found, is_new] = of_places.try_emplace({row.from, row.to}, labels_.size());
      if (is_new) labels_.push_back({.transitions = {}, .from = row.from, .to = row.to, .lines = {}, .edges = {}});
      add_lines(labels_[found->second], t);
    }
    nodes_.push_back({5, 5, 10});
    for (std::size_t p = 0; p < type_.places.size(); ++p)
      nodes_.push_back({place_width(p) / 2, place_width(p) / 2, kPlaceHeight});
    for (const Row p : type_.initial) edges_.push_back({0, p + 1, {}});
    std::vector<LabelLine> begin;
    add_broken(begin, text_of(code_, type_.initial_action, names_), "action");
    add_broken(begin, resume_text(code_, type_, type_.initial_resume), "dim");
    begin_ = std::move(begin);
    for (const LabelLine& line : begin_) nodes_[0].right = std::max(nodes_[0].right, 14 + text_width(line.text, kText));
    nodes_[0].height = std::max(10.0, kLine * static_cast<double>(begin_.size()) + 4);
    const std::vector<bool> leads_back = find_back_labels();
    for (Label& label : labels_) {
      if (label.is_loop()) {
        LayerNode& place = nodes_[label.from[0] + 1];
        label.node = label.from[0] + 1;
        place.right += kLoop + 6 + label.width();
        place.height = std::max(kPlaceHeight, label.height());
        continue;
      }
      label.node = static_cast<Row>(nodes_.size());
      const double beside = label.is_bar() ? kBar : 4;
      nodes_.push_back({beside, beside + 6 + label.width(), std::max(label.height(), 16.0)});
      BIP_ASSERT(!label.from.empty() && !label.to.empty(), "a transition of {} places to {}", label.from.size(),
                 label.to.size());
      label.is_back = leads_back[static_cast<std::size_t>(&label - labels_.data())];
      for (const Row p : label.from) add_edge(label, p + 1, label.node);
      for (const Row p : label.to) add_edge(label, label.node, p + 1);
    }
  }
  /// An edge of a transition that leads back is laid out the other way round, so that its label is between its places.
  void add_edge(Label& label, Row from, Row to) {
    label.edges.push_back(static_cast<Row>(edges_.size()));
    if (label.is_back) edges_.push_back({to, from, {}});
    else edges_.push_back({from, to, {}});
  }
  void restore_edges() {
    for (const Label& label : labels_) {
      if (!label.is_back) continue;
      for (const Row e : label.edges) {
        std::swap(edges_[e].from, edges_[e].to);
        std::reverse(edges_[e].points.begin(), edges_[e].points.end());
      }
    }
  }
  /// The transitions of one place to one place that close a cycle in a depth-first search from the initial places.
  [[nodiscard]] std::vector<bool> find_back_labels() const {
    std::vector<std::pair<Row, Row>> edges;
    std::vector<std::size_t> label_of;
    for (std::size_t k = 0; k < labels_.size(); ++k) {
      if (labels_[k].is_loop() || labels_[k].is_bar()) continue;
      edges.emplace_back(labels_[k].from[0], labels_[k].to[0]);
      label_of.push_back(k);
    }
    const std::vector<bool> edge_leads_back = edges_leading_back(type_.places.size(), edges, type_.initial);
    std::vector<bool> leads_back(labels_.size(), false);
    for (std::size_t e = 0; e < edges.size(); ++e) leads_back[label_of[e]] = edge_leads_back[e];
    return leads_back;
  }

  void add_lines(Label& label, Row t) {
    const Transition& row = type_.transitions[t];
    label.transitions.push_back(t);
    const bool is_internal = row.port == Transition::kInternal;
    label.is_internal = label.is_internal && is_internal;
    add_broken(label.lines, is_internal ? "internal" : type_.ports[row.port].name, is_internal ? "dim" : "bold");
    add_broken(label.lines, in_brackets(condition_of(code_, type_, row.guard, row.when)), "guard");
    if (row.urgency != Urgency::Lazy) label.lines.push_back({name_of(row.urgency), "dim"});
    add_broken(label.lines, text_of(code_, row.action, names_), "action");
    if (row.async.present) label.lines.push_back({"async", "dim"});
    add_broken(label.lines, resume_text(code_, type_, row.resume), "dim");
  }

  /// Lines that meet a place on the same side get places beside each other.
  void spread_ends() {
    spread_edge_ends(edges_, [this](Row node) {
      if (node == 0 || node > type_.places.size()) return EdgeRoom{};
      // A place whose loops need more height is as high as the others.
      return EdgeRoom{place_width(node - 1) - 20, (nodes_[node].height - kPlaceHeight) / 2};
    });
  }

  // -- Drawing --

  /// The name of the type, its data and what restricts its transitions; returns where the rest begins.
  double draw_heading() {
    const AtomTypeHeading heading = heading_of(code_, type_);
    std::vector<LabelLine> lines;
    add_broken(lines, heading.name, "bold");
    for (const std::string& line : heading.lines) add_broken(lines, line, "dim");
    double y = kSheetPad;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const double size = k == 0 ? 13 : 11;
      shapes_.text({kSheetPad, y + 11}, lines[k].text, size, Align::Left, lines[k].classes);
      heading_width_ = std::max(heading_width_, text_width(lines[k].text, size, weight_of(lines[k])));
      y += k == 0 ? 18 : 14;
    }
    return y + 8;
  }

  [[nodiscard]] Point shown(Point p) const { return {p.x + shift_.x, p.y + shift_.y}; }

  void arrow(const LayerEdge& edge, ArrowHead head) { draw_layer_arrow(shapes_, edge, shift_, head); }

  void draw_lines(const std::vector<LabelLine>& lines, double x, double top) {
    for (const LabelLine& line : lines) {
      shapes_.text({x, top + 10}, line.text, kText, Align::Left, line.classes);
      top += kLine;
    }
  }

  void draw_transition(std::size_t k) {
    const Label& label = labels_[k];
    std::string rows;
    for (const Row t : label.transitions) rows += (rows.empty() ? "" : " ") + std::to_string(t);
    shapes_.begin_group(label.is_internal ? "transition internal" : "transition",
                        fmt::format(" data-transition=\"{}\"", rows));
    std::string title;
    for (const Row t : label.transitions) {
      const Transition& row = type_.transitions[t];
      title += (title.empty() ? "" : "\n") +
               (row.port == Transition::kInternal ? std::string("internal") : type_.ports[row.port].name) + ": " +
               list_of(row.from, type_.places) + " -> " + list_of(row.to, type_.places) + " " +
               in_brackets(condition_of(code_, type_, row.guard, row.when)) + " " + text_of(code_, row.action, names_);
    }
    shapes_.title(title);
    const LayerNode& node = nodes_[label.node];
    const Point at = shown({node.x, node.y});
    if (label.is_loop()) {
      const double edge = at.x + place_width(label.from[0]) / 2, middle = at.y + node.height / 2;
      shapes_.path(fmt::format("M{0} {1}C{2} {3} {2} {4} {0} {5}", coordinate(edge - 4), coordinate(middle - 6),
                               coordinate(edge + kLoop), coordinate(middle - 18), coordinate(middle + 18),
                               coordinate(middle + 6)),
                   "arrow");
      shapes_.path(fmt::format("M{} {}l8 -1l-2 7Z", coordinate(edge - 3), coordinate(middle + 5)), "head");
      draw_lines(label.lines, edge + kLoop, middle - label.height() / 2 + 1);
    } else {
      for (const Row e : label.edges) arrow(edges_[e], edges_[e].to == label.node ? ArrowHead::None : ArrowHead::AtEnd);
      const double height = node.height, beside = label.is_bar() ? kBar : 4;
      shapes_.path(fmt::format("M{} {}v{}", coordinate(at.x), coordinate(at.y), coordinate(height)), "arrow");
      if (label.is_bar()) shapes_.box(at.x - kBar, at.y + height / 2 - 2, 2 * kBar, 4, 1, "bar");
      draw_lines(label.lines, at.x + beside + 4, at.y + (height - label.height()) / 2 + 1);
    }
    shapes_.end_group();
  }

  void draw_initial() {
    shapes_.begin_group("initial");
    const LayerNode& node = nodes_[0];
    const Point at = shown({node.x, node.y + node.height - 5});
    shapes_.circle(at, 4, "dot");
    draw_lines(begin_, at.x + 10, shown({0, node.y}).y);
    for (std::size_t k = 0; k < type_.initial.size(); ++k) arrow(edges_[k], ArrowHead::AtEnd);
    shapes_.end_group();
  }

  void draw_place(std::size_t p) {
    const LayerNode& node = nodes_[p + 1];
    const double width = place_width(p);
    const Point at = shown({node.x - width / 2, node.y + (node.height - kPlaceHeight) / 2});
    shapes_.begin_group("state", fmt::format(" data-place=\"{}\"", p));
    shapes_.box(at.x, at.y, width, kPlaceHeight, kPlaceHeight / 2, "place");
    if (std::binary_search(type_.final_places.begin(), type_.final_places.end(), static_cast<Row>(p)))
      shapes_.box(at.x + 3, at.y + 3, width - 6, kPlaceHeight - 6, kPlaceHeight / 2 - 3, "final");
    shapes_.text({at.x + width / 2, at.y + kPlaceHeight / 2 + 4}, type_.places[p], 11, Align::Middle, "");
    shapes_.end_group();
  }

  const CodeTable& code_;
  const AtomType& type_;
  CodeNames names_;
  std::vector<Label> labels_;
  std::vector<LayerNode> nodes_;  // the initial dot, places, transitions
  std::vector<LayerEdge> edges_;  // those of the initial dot first
  std::vector<LabelLine> begin_;
  double heading_width_ = 0;
  Point shift_;
  Shapes shapes_;
};

}  // namespace

Picture automaton_picture(const System& system, AtomTypeId type) { return AutomatonDrawing(system, type).run(); }

}  // namespace bip::graph
