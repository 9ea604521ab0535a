// Draws robot modules: a box for each module and each rule, solid arrows for posters that are read, dashed ones from
// what a rule looks at to the rule, and from there to the services that it restricts. Layout: layers.hpp.
#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "compiler/graph/label_lines.hpp"
#include "compiler/graph/layer_arrows.hpp"
#include "compiler/graph/layers.hpp"
#include "compiler/graph/module_graph.hpp"

namespace bip::graph {
namespace {

constexpr double kModuleText = 10, kModuleLine = 13, kModuleTitle = 12, kModulePad = 9, kModuleEdge = 14;
constexpr std::size_t kMostRows = 12;  // lines of names of one kind

class ModuleDrawing {
 public:
  explicit ModuleDrawing(const ModuleGraph& graph) : graph_(graph) {}

  std::string run() {
    for (const ModuleRow& module : graph_.modules) add_box(lines_of_module(module));
    for (const RuleRow& rule : graph_.rules) add_box(lines_of_rule(rule));
    find_links();
    add_edges();
    const LayerSize size = lay_out_layers(nodes_, edges_);
    restore_edges();
    spread_edge_ends(edges_, [this](std::uint32_t node) {
      return node < boxes_.size() ? EdgeRoom{2 * nodes_[node].left - 24, 0} : EdgeRoom{};
    });
    for (const Link& link : links_) draw_link(link);
    for (std::size_t k = 0; k < boxes_.size(); ++k) draw_box(k);
    return svg_document({shapes_.elements(), size.width + 2 * kModuleEdge, size.height + 2 * kModuleEdge},
                        "robot modules " + graph_.name);
  }

 private:
  /// From one box to another. Of posters that are read: with their names beside it.
  struct Link {
    std::uint32_t from = 0, to = 0;
    bool is_rule = false;
    std::vector<LabelLine> lines = {};
    bool is_back = false;
    std::uint32_t label = 0;  // its node
    std::vector<std::uint32_t> edges = {};
  };

  template <class Rows, class Text>
  static void add_names(std::vector<LabelLine>& lines, const char* what, const Rows& rows, Text text,
                        const char* classes) {
    std::string all;
    for (const auto& row : rows) {
      const std::string name = text(row);
      if (!name.empty()) all += (all.empty() ? std::string(what) + ": " : ", ") + name;
    }
    add_broken(lines, std::move(all), classes, kMostRows);
  }

  static std::vector<LabelLine> lines_of_module(const ModuleRow& module) {
    std::vector<LabelLine> lines{{module.name, "bold"}};
    add_names(
        lines, "tasks", module.tasks,
        [](const ModuleRow::Task& t) { return t.period.empty() ? t.name : t.name + " " + t.period; }, "dim");
    const auto name = [](const std::string& text) { return text; };
    add_names(lines, "in", module.in_ports, name, "dim");
    using Service = ModuleRow::Service;
    add_names(
        lines, "activities", module.services, [](const Service& s) { return s.is_activity ? s.name : ""; }, "");
    add_names(
        lines, "control", module.services, [](const Service& s) { return s.is_activity ? "" : s.name; }, "");
    add_names(lines, "posters", module.posters, name, "action");
    return lines;
  }

  static std::vector<LabelLine> lines_of_rule(const RuleRow& rule) {
    std::vector<LabelLine> lines;
    add_broken(lines, rule.name, "bold");
    add_broken(lines, rule.text, "");
    add_broken(lines, rule.report, "guard");
    return lines;
  }

  void add_box(std::vector<LabelLine> lines) {
    const double width = std::max(60.0, width_of(lines, kModuleTitle) + 2 * kModulePad);
    const double height = kModuleLine * static_cast<double>(lines.size()) + 2 * kModulePad;
    nodes_.push_back({width / 2, width / 2, height});
    boxes_.push_back(std::move(lines));
  }

  void find_links() {
    std::map<std::pair<std::size_t, std::size_t>, std::vector<std::string>> posters;
    const auto add = [&](const ModuleMember& poster, std::size_t reader) {
      if (poster.module == reader) return;
      std::vector<std::string>& names = posters[{poster.module, reader}];
      const std::string& name = graph_.modules[poster.module].posters[poster.row];
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    };
    for (const PosterRead& read : graph_.reads) add(read.poster, read.module);
    for (const PortConnection& connection : graph_.connections) add(connection.poster, connection.in_port.module);
    for (const auto& [ends, names] : posters) {
      Link& link = links_.emplace_back();
      link.from = static_cast<std::uint32_t>(ends.first);
      link.to = static_cast<std::uint32_t>(ends.second);
      for (const std::string& name : names) add_broken(link.lines, name, "action");
    }
    for (std::size_t r = 0; r < graph_.rules.size(); ++r) {
      const RuleRow& rule = graph_.rules[r];
      const auto box = static_cast<std::uint32_t>(graph_.modules.size() + r);
      std::set<std::size_t> subjects, seen;
      for (const ModuleMember& subject : rule.subjects) subjects.insert(subject.module);
      if (rule.recovery) subjects.insert(rule.recovery->module);
      for (const auto* members : {&rule.services, &rule.posters, &rule.tasks}) {
        for (const ModuleMember& member : *members) {
          if (!subjects.contains(member.module)) seen.insert(member.module);
        }
      }
      for (const std::size_t module : seen)
        links_.push_back({.from = static_cast<std::uint32_t>(module), .to = box, .is_rule = true});
      for (const std::size_t module : subjects)
        links_.push_back({.from = box, .to = static_cast<std::uint32_t>(module), .is_rule = true});
    }
  }

  void add_edges() {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;
    for (const Link& link : links_) ends.emplace_back(link.from, link.to);
    const std::vector<bool> leads_back = edges_leading_back(boxes_.size(), ends);
    for (std::size_t k = 0; k < links_.size(); ++k) {
      Link& link = links_[k];
      link.is_back = leads_back[k];
      if (link.is_rule) {
        add_edge(link, link.from, link.to);
        continue;
      }
      link.label = static_cast<std::uint32_t>(nodes_.size());
      nodes_.push_back(
          {4, 10 + width_of(link.lines, kModuleText), kModuleLine * static_cast<double>(link.lines.size()) + 4});
      add_edge(link, link.from, link.label);
      add_edge(link, link.label, link.to);
    }
  }
  // An edge that leads back is laid out the other way round, so that names are between their boxes.
  void add_edge(Link& link, std::uint32_t from, std::uint32_t to) {
    link.edges.push_back(static_cast<std::uint32_t>(edges_.size()));
    if (link.is_back) edges_.push_back({to, from, {}});
    else edges_.push_back({from, to, {}});
  }
  void restore_edges() {
    for (const Link& link : links_) {
      if (!link.is_back) continue;
      for (const std::uint32_t e : link.edges) {
        std::swap(edges_[e].from, edges_[e].to);
        std::reverse(edges_[e].points.begin(), edges_[e].points.end());
      }
    }
  }

  void draw_lines(const std::vector<LabelLine>& lines, Point at) {
    for (const LabelLine& line : lines) {
      const bool is_title = weight_of(line) == Weight::Bold;
      shapes_.text({at.x, at.y + 10}, line.text, is_title ? kModuleTitle : kModuleText, Align::Left, line.classes);
      at.y += kModuleLine;
    }
  }

  void draw_link(const Link& link) {
    shapes_.begin_group(link.is_rule ? "link internal" : "link");
    for (const std::uint32_t e : link.edges) {
      const bool is_last = e == link.edges.back();
      draw_layer_arrow(shapes_, edges_[e], kShift, is_last ? ArrowHead::AtEnd : ArrowHead::None);
    }
    if (!link.is_rule) {
      const LayerNode& node = nodes_[link.label];
      const Point at{node.x + kShift.x, node.y + kShift.y};
      shapes_.path(fmt::format("M{} {}v{}", coordinate(at.x), coordinate(at.y), coordinate(node.height)), "arrow");
      draw_lines(link.lines, {at.x + 6, at.y + 2});
    }
    shapes_.end_group();
  }

  void draw_box(std::size_t k) {
    const LayerNode& node = nodes_[k];
    const Point at{node.x - node.left + kShift.x, node.y + kShift.y};
    const bool is_rule = k >= graph_.modules.size();
    shapes_.begin_group(is_rule ? "rule" : "module",
                        fmt::format(" data-name=\"{}\"", escaped_markup(boxes_[k][0].text)));
    if (is_rule) shapes_.title(graph_.rules[k - graph_.modules.size()].text);
    shapes_.box(at.x, at.y, 2 * node.left, node.height, is_rule ? 12 : 3, is_rule ? "frame c1" : "frame c0");
    draw_lines(boxes_[k], {at.x + kModulePad, at.y + kModulePad});
    shapes_.end_group();
  }

  static constexpr Point kShift{kModuleEdge, kModuleEdge};

  const ModuleGraph& graph_;
  std::vector<std::vector<LabelLine>> boxes_;  // modules, then rules
  std::vector<LayerNode> nodes_;               // the same, then names of posters
  std::vector<LayerEdge> edges_;
  std::vector<Link> links_;
  Shapes shapes_;
};

}  // namespace

std::string svg(const ModuleGraph& graph) { return ModuleDrawing(graph).run(); }

}  // namespace bip::graph
