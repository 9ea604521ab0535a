// Components and connectors as DOT: one cluster per compound, one record per atom with its exported ports, one rounded
// box per connector. Iterative over the hierarchy.
#include <fmt/format.h>

#include <iterator>

#include "compiler/graph/code_text.hpp"
#include "compiler/graph/dot.hpp"
#include "compiler/system/system.hpp"

namespace bip::graph {
namespace {

/// Rows that stand directly in a compound.
struct Content {
  std::vector<std::size_t> compounds, atoms, connectors;
};

class Structure {
 public:
  Structure(std::string& out, const System& system) : out_(out), system_(system), contents_(system.compounds.size()) {
    for (std::size_t k = 0; k < system_.compounds.size(); ++k)
      if (const CompoundId in = system_.compounds[CompoundId(k)].parent; in.is_valid())
        contents_[in.value].compounds.push_back(k);
    for (std::size_t k = 0; k < system_.atoms.size(); ++k)
      contents_[system_.atoms[AtomId(k)].parent.value].atoms.push_back(k);
    for (std::size_t k = 0; k < system_.connectors.size(); ++k)
      contents_[system_.connectors[ConnectorId(k)].parent.value].connectors.push_back(k);
  }

  void run() {
    clusters();
    for (std::size_t k = 0; k < system_.choices.size(); ++k) choice(k);
    for (std::size_t k = 0; k < system_.connectors.size(); ++k) bindings(k);
    for (std::size_t k = 0; k < system_.priorities.size(); ++k) priority(k);
  }

 private:
  template <class... Args>
  void put(fmt::format_string<Args...> text, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), text, std::forward<Args>(args)...);
  }

  /// "lamp" of ROOT.room.lamp in ROOT.room.
  [[nodiscard]] std::string own_name(const std::string& path, CompoundId parent) const {
    const std::string outer = parent.is_valid() ? system_.compounds[parent].path + "." : "";
    return path.starts_with(outer) ? path.substr(outer.size()) : path;
  }

  void clusters() {
    struct Open {
      std::size_t compound, next;
    };
    std::vector<Open> open{{0, 0}};
    begin_cluster(0, 1);
    while (!open.empty()) {
      const std::vector<std::size_t>& inner = contents_[open.back().compound].compounds;
      if (open.back().next < inner.size()) {
        const std::size_t compound = inner[open.back().next++];
        open.push_back({compound, 0});
        begin_cluster(compound, open.size());
      } else {
        put("{:{}}}}\n", "", 2 * open.size());
        open.pop_back();
      }
    }
  }

  void begin_cluster(std::size_t k, std::size_t depth) {
    const Compound& row = system_.compounds[CompoundId(k)];
    const std::string indent(2 * depth, ' ');
    put("{}subgraph cluster_c{} {{\n", indent, k);
    put("{}  label={};\n", indent, dot_string(own_name(row.path, row.parent) + " : " + row.type));
    for (const std::size_t atom : contents_[k].atoms) out_ += indent + "  " + atom_node(atom);
    for (const std::size_t connector : contents_[k].connectors) out_ += indent + "  " + connector_node(connector);
  }

  std::string atom_node(std::size_t k) const {
    const Atom& row = system_.atoms[AtomId(k)];
    const AtomType& type = system_.atom_types[row.type];
    std::string args;
    for (std::size_t a = 0; a < row.args.size(); ++a) args += (a == 0 ? "" : ", ") + text_of(system_.code, row.args[a]);
    std::string ports;
    for (std::size_t p = 0; p < type.ports.size(); ++p) {
      if (!type.ports[p].exported) continue;
      ports += fmt::format("|<p{}> {}", p, record_field(type.ports[p].name));
    }
    const std::string name =
        shortened(own_name(row.path, row.parent) + " : " + type.name + (args.empty() ? "" : "(" + args + ")"));
    return fmt::format("a{} [shape=record, label=\"{}{}\"];\n", k, record_field(name), ports);
  }

  std::string connector_node(std::size_t k) const {
    const Connector& row = system_.connectors[ConnectorId(k)];
    const ConnectorType& type = system_.connector_types[row.type];
    std::vector<std::string> lines{own_name(row.path, row.parent), shortened(define_of(type))};
    const CodeNames names = names_of(system_, type);
    for (const Clause& clause : type.clauses)
      if (const std::string guard = text_of(system_.code, clause.guard, names); !guard.empty())
        lines.push_back(shortened("[" + guard + "]"));
    return fmt::format("k{} [shape=box, style=rounded, label={}];\n", k, dot_string(lines_of(lines)));
  }

  [[nodiscard]] std::string end_of(const PortRef& port) const {
    switch (port.kind) {
      case PortRef::Kind::Atom: return fmt::format("a{}:p{}", port.atom.value, port.port);
      case PortRef::Kind::Connector: return fmt::format("k{}", port.connector.value);
      case PortRef::Kind::Choice: break;
    }
    return fmt::format("m{}", port.choice);
  }

  void choice(std::size_t k) {
    put("  m{} [shape=diamond, label={}];\n", k, dot_string(system_.choices[k].name));
    for (const PortRef& port : system_.choices[k].ports) put("  {} -> m{} [dir=none];\n", end_of(port), k);
  }

  void bindings(std::size_t k) {
    const Connector& row = system_.connectors[ConnectorId(k)];
    const ConnectorType& type = system_.connector_types[row.type];
    std::vector<bool> triggers(type.params.size());
    for (const DefineNode& node : type.define)
      if (node.is_leaf) triggers[node.param] = node.trigger;
    for (std::size_t p = 0; p < row.ports.size(); ++p) {
      const char* maximal = row.ports[p].maximal_only ? ", label=\"maximal\"" : "";
      put("  {} -> k{} [dir=back, arrowtail={}{}];\n", end_of(row.ports[p]), k, triggers[p] ? "normal" : "dot",
          maximal);
    }
    for (const DataRef& data : row.data) {
      const std::string& name = system_.atom_types[system_.atoms[data.atom].type].variables[data.variable].name;
      put("  a{} -> k{} [style=dotted, arrowhead=vee, label={}];\n", data.atom.value, k, dot_string(name));
    }
  }

  // A side that is no connector gets a node of its own.
  std::string side(std::size_t k, const Pattern& pattern, const char* which) {
    if (!pattern.any_connector) return fmt::format("k{}", pattern.connector.value);
    put("  r{}_{} [shape=plaintext, label=\"*:*\"];\n", k, which);
    return fmt::format("r{}_{}", k, which);
  }
  [[nodiscard]] std::string pattern_text(const Pattern& pattern) const {
    if (pattern.any_connector) return "*:*";
    if (pattern.any_interaction) return "*";
    const ConnectorType& type = system_.connector_types[system_.connectors[pattern.connector].type];
    std::string out;
    for (const std::uint32_t p : pattern.params) out += (out.empty() ? "" : " ") + type.params[p].name;
    return out;
  }
  void priority(std::size_t k) {
    const Priority& row = system_.priorities[PriorityId(k)];
    const std::string low = side(k, row.low, "low");
    const std::string high = side(k, row.high, "high");
    const bool whole = row.low.any_connector || row.low.any_interaction;
    const bool is_plain = whole && (row.high.any_connector || row.high.any_interaction);
    const std::string sides = is_plain ? "" : pattern_text(row.low) + " < " + pattern_text(row.high);
    std::string guard = text_of(system_.code, row.guard, names_of(system_, row));
    if (!guard.empty()) guard = "[" + guard + "]";
    // Not `label`: with it Graphviz 2.42 fails ("trouble in init_rank") where such edges cross clusters.
    put("  {} -> {} [style=dashed, arrowhead=empty, constraint=false, xlabel={}];\n", low, high,
        dot_string(lines_of({row.name, shortened(sides), shortened(guard)})));
  }

  std::string& out_;
  const System& system_;
  std::vector<Content> contents_;
};

}  // namespace

void put_structure(std::string& out, const System& system) { Structure(out, system).run(); }

}  // namespace bip::graph
