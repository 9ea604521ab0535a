// The whole system as one network: the graph of its connectors (compiler/analysis/connector_graph.hpp), and for each
// atom its modes and how the leaves move it between them.
//
// Built once, linear in the system. Modes get global numbers, atom by atom, as the leaves do.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "compiler/analysis/connector_graph.hpp"
#include "compiler/system/system_ids.hpp"
#include "compiler/verify/net/modes.hpp"

namespace bip::verify {

using u32 = std::uint32_t;
inline constexpr u32 kNoRow = 0xffffffffu;

using analysis::ConnectorNodeKind;
using Edge = analysis::ConnectorGraph::Edge;
using Node = analysis::ConnectorGraph::Node;

struct Net {
  const System* system = nullptr;
  std::vector<analysis::DataAccess> access;  // by atom type
  std::vector<ModeClass> classes;
  std::vector<u32> class_of;       // by atom
  std::vector<u32> mode_base;      // by atom, and the total
  std::vector<u32> atom_of_mode;   // by mode
  analysis::ConnectorGraph graph;  // its leaves: an atom's ports, then the distinguished uses of its ports
  PortUses uses;                   // the distinguished ones; empty if there are none
  u32 too_large_atom = kNoRow;     // its modes are too many: the net is not usable

  [[nodiscard]] u32 mode_count() const { return mode_base.back(); }
  [[nodiscard]] const ModeClass& class_at(u32 atom) const { return classes[class_of[atom]]; }
  /// Moves of a port instance, modes as numbers of the class; add mode_base[graph.atom_of_port[port]].
  [[nodiscard]] std::span<const Move> moves(u32 port) const {
    const u32 atom = graph.atom_of_port[port];
    return class_at(atom).moves[port - graph.port_base[atom]];
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
  /// Leaf of a parameter that is bound to an atom's port, counted from the atom's first.
  [[nodiscard]] u32 leaf_of(ConnectorId connector, std::size_t param) const;
  /// Node of a parameter that is bound to an atom's port.
  [[nodiscard]] u32 port_node(ConnectorId connector, std::size_t param) const;
  /// "phil[0]@EATS"
  [[nodiscard]] std::string mode_name(u32 mode) const;
};

[[nodiscard]] Net build_net(const System& system);
/// The same system, with uses of ports told apart (Ports), or with their values hidden, for the same atoms (Hidden).
[[nodiscard]] Net build_net(const Net& plain, const PortUses& uses, UsesAs as);

}  // namespace bip::verify
