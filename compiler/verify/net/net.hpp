// The whole system as one network: atoms with their modes, their ports as leaves, connectors' `define` trees above
// them. An inner connector is one node that its users share; no interaction is ever listed.
//
// Built once, linear in the system. Modes get global numbers, atom by atom; so do ports (nodes [0, port_count)), an
// atom's uses of ports that are told apart after its ports.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "compiler/system/system.hpp"
#include "compiler/verify/net/modes.hpp"

namespace bip::verify {

using u32 = std::uint32_t;
inline constexpr u32 kNoRow = 0xffffffffu;

/// Port: of an atom. All: a rendezvous. Trigger: a group with triggers. Any: exactly one of its children (merged
/// ports).
enum class NodeKind : std::uint8_t { Port, All, Trigger, Any };
struct Edge {
  u32 node = 0;
  bool is_trigger = false;
};
struct Node {
  NodeKind kind = NodeKind::Port;
  bool is_root = false;  // its choices are steps: a connector that exports no port, or an internal port
  u32 first_child = 0, children = 0;
  u32 first_parent = 0, parents = 0;
  u32 connector = kNoRow;  // root group of this connector
};

struct Net {
  const System* system = nullptr;
  std::vector<analysis::DataAccess> access;  // by atom type
  std::vector<ModeClass> classes;
  std::vector<u32> class_of;              // by atom
  std::vector<u32> mode_base, port_base;  // by atom, and the total
  std::vector<u32> atom_of_mode, atom_of_port;
  std::vector<Node> nodes;  // children before parents
  std::vector<Edge> child_edges, parent_edges;
  std::vector<u32> root_of;     // by connector: its root group
  PortUses uses;                // told apart; else empty
  u32 too_large_atom = kNoRow;  // its modes are too many: the net is not usable

  [[nodiscard]] u32 mode_count() const { return mode_base.back(); }
  [[nodiscard]] u32 port_count() const { return port_base.back(); }
  [[nodiscard]] const ModeClass& class_at(u32 atom) const { return classes[class_of[atom]]; }
  [[nodiscard]] std::span<const Edge> children(u32 node) const {
    return {child_edges.data() + nodes[node].first_child, nodes[node].children};
  }
  [[nodiscard]] std::span<const Edge> parents(u32 node) const {
    return {parent_edges.data() + nodes[node].first_parent, nodes[node].parents};
  }
  /// Moves of a port instance, modes as numbers of the class; add mode_base[atom_of_port[port]].
  [[nodiscard]] std::span<const Move> moves(u32 port) const {
    const u32 atom = atom_of_port[port];
    return class_at(atom).moves[port - port_base[atom]];
  }
  /// Port and other end of the moves out of (into) a mode; numbers of the class.
  [[nodiscard]] std::span<const PortMove> moves_out(u32 mode) const {
    const u32 atom = atom_of_mode[mode];
    return class_at(atom).out[mode - mode_base[atom]];
  }
  [[nodiscard]] std::span<const PortMove> moves_in(u32 mode) const {
    const u32 atom = atom_of_mode[mode];
    return class_at(atom).in[mode - mode_base[atom]];
  }
  /// Node of a parameter that is bound to an atom's port.
  [[nodiscard]] u32 port_node(ConnectorId connector, std::size_t param) const {
    const PortRef& ref = system->connectors[connector].ports[param];
    const u32 base = port_base[ref.atom.value];
    const bool has_uses = !uses.of_param.empty() && !uses.of_param[connector.value].empty();
    const u32 use = has_uses ? uses.of_param[connector.value][param] : 0;
    return use == 0 ? base + ref.port : base + static_cast<u32>(class_at(ref.atom.value).is_sure.size()) + use - 1;
  }
  /// "phil[0]@EATS"
  [[nodiscard]] std::string mode_name(u32 mode) const;
};

[[nodiscard]] Net build_net(const System& system);
/// The same system, with uses of ports told apart (Ports), or with their values hidden, for the same atoms (Hidden).
[[nodiscard]] Net build_net(const Net& plain, const PortUses& uses, UsesAs as);

}  // namespace bip::verify
