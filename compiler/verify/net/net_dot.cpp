// See net_dot.hpp.
#include "compiler/verify/net/net_dot.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

std::string dot_quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

const char* node_label(ConnectorNodeKind kind) {
  switch (kind) {
    case ConnectorNodeKind::Port: return "port";
    case ConnectorNodeKind::All: return "all";
    case ConnectorNodeKind::Trigger: return "trigger";
    case ConnectorNodeKind::Any: return "one of";
  }
  BIP_UNREACHABLE("kind of a node");
}

void add_atom(const Net& net, u32 atom, std::string& text) {
  const ModeClass& modes = net.class_at(atom);
  const AtomType& type = net.system->atom_types[modes.type];
  const u32 first_mode = net.mode_base[atom], first_port = net.graph.port_base[atom];
  text += fmt::format("  subgraph cluster_{} {{\n    label={};\n", atom,
                      dot_quoted(net.system->atoms[AtomId(std::size_t{atom})].path));
  for (u32 mode = 0; mode < modes.modes.size(); ++mode) {
    const bool is_initial = std::binary_search(modes.initial.begin(), modes.initial.end(), mode);
    text += fmt::format("    m{} [label={}, shape=ellipse{}];\n", first_mode + mode,
                        dot_quoted(mode_text(*net.system, modes, mode)), is_initial ? ", peripheries=2" : "");
  }
  for (u32 row = 0; row < modes.moves.size(); ++row) {
    const std::string& port = type.ports[modes.port_of(row)].name;
    text += fmt::format("    n{} [label={}, shape=box];\n", first_port + row, dot_quoted(port));
    for (const Move& move : modes.moves[row])
      text +=
          fmt::format("    m{} -> m{} [label={}];\n", first_mode + move.from, first_mode + move.to, dot_quoted(port));
  }
  text += "  }\n";
}

}  // namespace

std::string net_dot(const Net& net) {
  std::string text = "digraph net {\n  rankdir=TB;\n";
  for (u32 atom = 0; atom + 1 < net.mode_base.size(); ++atom) add_atom(net, atom, text);
  for (u32 row = net.graph.port_count(); row < net.graph.nodes.size(); ++row) {
    const Node& node = net.graph.nodes[row];
    const bool is_connector = node.connector != analysis::ConnectorGraph::kNoConnector;
    const std::string name =
        is_connector ? net.system->connectors[ConnectorId(std::size_t{node.connector})].path + ": " : std::string();
    text += fmt::format("  n{} [label={}, shape={}];\n", row, dot_quoted(name + node_label(node.kind)),
                        node.is_root ? "doubleoctagon" : "octagon");
    for (const Edge& edge : net.graph.children(row))
      text += fmt::format("  n{} -> n{}{};\n", row, edge.node, edge.is_trigger ? " [style=dashed]" : "");
  }
  return text + "}\n";
}

}  // namespace bip::verify
