// The connectors of a whole system as one acyclic graph: the ports of atoms as leaves, the trees of `define` above
// them. A connector that others bind is one node that its users share, so the graph is linear in the System and no
// interaction is ever listed.
//
// What can be said of a node from its children alone (may it be available, how many tokens does it move) is computed in
// one pass over the rows, because children come before their parents.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "compiler/system/system_ids.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::analysis {

using u32 = std::uint32_t;

/// Port: of an atom. All: a rendezvous. Trigger: a group with triggers. Any: exactly one of its children (merged
/// ports).
enum class ConnectorNodeKind : std::uint8_t { Port, All, Trigger, Any };

struct ConnectorGraph {
  static constexpr u32 kNoConnector = 0xffffffffu;
  struct Edge {
    u32 node = 0;
    bool is_trigger = false;
  };
  struct Node {
    ConnectorNodeKind kind = ConnectorNodeKind::Port;
    bool is_root = false;  // its choices are steps: a connector that exports no port, or an internal port
    u32 first_child = 0, children = 0;
    u32 first_parent = 0, parents = 0;
    u32 connector = kNoConnector;  // root group of this connector
  };

  std::vector<u32> port_base;     // by atom: its first leaf; and the number of leaves
  std::vector<u32> atom_of_port;  // by leaf
  std::vector<Node> nodes;        // children before parents; leaves are the rows [0, port_count())
  std::vector<Edge> child_edges, parent_edges;
  std::vector<u32> root_of;  // by connector: its root group

  /// Returns the number of leaves.
  [[nodiscard]] u32 port_count() const { return port_base.back(); }
  [[nodiscard]] std::span<const Edge> children(u32 node) const {
    BIP_ASSERT(node < nodes.size(), "node {} of {}", node, nodes.size());
    return {child_edges.data() + nodes[node].first_child, nodes[node].children};
  }
  [[nodiscard]] std::span<const Edge> parents(u32 node) const {
    BIP_ASSERT(node < nodes.size(), "node {} of {}", node, nodes.size());
    return {parent_edges.data() + nodes[node].first_parent, nodes[node].parents};
  }
};

/// The leaves of the graph. By default one per port of an atom; a prover may tell apart what uses a port, by more
/// leaves after those of the ports.
struct ConnectorLeaves {
  std::vector<u32> of_atom;  // by atom: number of leaves, at least its type's ports; empty: the ports
  /// The leaf of a parameter that is bound to an atom's port, counted from the atom's first; null: the port.
  std::function<u32(ConnectorId connector, u32 param)> of_param;
};

/// Builds the graph of a valid System. Linear.
[[nodiscard]] ConnectorGraph build_connector_graph(const System& system, const ConnectorLeaves& leaves = {});

}  // namespace bip::analysis
