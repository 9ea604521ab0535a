// See connector_graph.hpp.
#include "compiler/analysis/connector_graph.hpp"

#include <utility>

#include "compiler/system/system.hpp"

namespace bip::analysis {

namespace {

class ConnectorGraphBuilder {
 public:
  ConnectorGraphBuilder(const System& system, const ConnectorLeaves& leaves) : system_(system), leaves_(leaves) {}

  ConnectorGraph build() {
    add_leaves();
    for (const Choice& choice : system_.choices) choice_rows_.push_back(choice.ports.empty() ? kNothing : kUnmade);
    for (std::size_t row = 0; row < system_.connectors.size(); ++row) add_connector(ConnectorId(row));
    add_parents();
    return std::move(graph_);
  }

 private:
  static constexpr u32 kNothing = 0xffffffffu, kUnmade = kNothing - 1;
  using Edge = ConnectorGraph::Edge;
  using Node = ConnectorGraph::Node;

  void add_leaves() {
    u32 count = 0;
    for (std::size_t row = 0; row < system_.atoms.size(); ++row) {
      const AtomType& type = system_.atom_types[system_.atoms[AtomId(row)].type];
      const u32 ports = static_cast<u32>(type.ports.size());
      const u32 own = leaves_.of_atom.empty() ? ports : leaves_.of_atom[row];
      BIP_ASSERT(own >= ports, "atom {} has {} ports and {} leaves", row, ports, own);
      graph_.port_base.push_back(count);
      count += own;
      graph_.atom_of_port.resize(count, static_cast<u32>(row));
      for (const Port& port : type.ports) {
        Node node;
        node.is_root = !port.exported;
        graph_.nodes.push_back(node);
      }
      graph_.nodes.resize(count);
    }
    graph_.port_base.push_back(count);
  }

  u32 leaf(AtomId atom, u32 own) const {
    const u32 row = graph_.port_base[atom.value] + own;
    BIP_ASSERT(row < graph_.port_base[atom.value + 1], "leaf {} of atom {}", own, atom.value);
    return row;
  }
  u32 node_of(const PortRef& ref) {
    switch (ref.kind) {
      case PortRef::Kind::Atom: return leaf(ref.atom, ref.port);
      case PortRef::Kind::Connector:
        BIP_ASSERT(ref.connector.value < graph_.root_of.size(), "connector {} comes after its user",
                   ref.connector.value);
        return graph_.root_of[ref.connector.value];
      case PortRef::Kind::Choice: break;
    }
    u32& row = choice_rows_[ref.choice];
    if (row == kUnmade) {
      // No choice is among the ports of a choice.
      std::vector<Edge> edges;
      for (const PortRef& port : system_.choices[ref.choice].ports) edges.push_back({node_of(port), false});
      row = add(ConnectorNodeKind::Any, edges);
    }
    return row;
  }
  u32 add(ConnectorNodeKind kind, const std::vector<Edge>& edges) {
    const u32 row = static_cast<u32>(graph_.nodes.size());
    Node node;
    node.kind = kind;
    node.first_child = static_cast<u32>(graph_.child_edges.size());
    node.children = static_cast<u32>(edges.size());
    for (const Edge& edge : edges) BIP_ASSERT(edge.node < row, "node {} has the child {}", row, edge.node);
    graph_.child_edges.insert(graph_.child_edges.end(), edges.begin(), edges.end());
    graph_.nodes.push_back(node);
    return row;
  }

  // Rows of `define` are greater than their parent's, so backwards is bottom up.
  void add_connector(ConnectorId id) {
    const Connector& connector = system_.connectors[id];
    const ConnectorType& type = system_.connector_types[connector.type];
    std::vector<u32> made(type.define.size(), kNothing);
    for (std::size_t row = type.define.size(); row-- > 0;) {
      const DefineNode& define = type.define[row];
      if (define.is_leaf) {
        const PortRef& ref = connector.ports[define.param];
        const bool is_told_apart = ref.kind == PortRef::Kind::Atom && leaves_.of_param;
        made[row] = is_told_apart ? leaf(ref.atom, leaves_.of_param(id, define.param)) : node_of(ref);
        continue;
      }
      std::vector<Edge> edges;
      bool has_trigger = false;
      for (u32 child : define.children) {
        edges.push_back({made[child], type.define[child].trigger});
        has_trigger = has_trigger || type.define[child].trigger;
      }
      made[row] = add(has_trigger ? ConnectorNodeKind::Trigger : ConnectorNodeKind::All, edges);
    }
    // A tree that is one leaf gets a group around it, so that the root is this connector's own.
    const u32 root = type.define[0].is_leaf ? add(ConnectorNodeKind::All, {{made[0], false}}) : made[0];
    graph_.nodes[root].connector = id.value;
    graph_.nodes[root].is_root = !type.exports;
    graph_.root_of.push_back(root);
  }

  void add_parents() {
    for (const Edge& edge : graph_.child_edges) ++graph_.nodes[edge.node].parents;
    u32 next = 0;
    for (Node& node : graph_.nodes) {
      node.first_parent = next;
      next += node.parents;
      node.parents = 0;
    }
    graph_.parent_edges.resize(next);
    for (u32 row = 0; row < graph_.nodes.size(); ++row) {
      for (const Edge& edge : graph_.children(row)) {
        Node& child = graph_.nodes[edge.node];
        graph_.parent_edges[child.first_parent + child.parents++] = {row, edge.is_trigger};
      }
    }
  }

  const System& system_;
  const ConnectorLeaves& leaves_;
  ConnectorGraph graph_;
  std::vector<u32> choice_rows_;
};

}  // namespace

ConnectorGraph build_connector_graph(const System& system, const ConnectorLeaves& leaves) {
  return ConnectorGraphBuilder(system, leaves).build();
}

}  // namespace bip::analysis
