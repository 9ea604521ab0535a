// See local_deadlock.hpp.
#include "compiler/verify/portfolio/local_deadlock.hpp"

#include "compiler/system/system.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

std::vector<u32> locally_deadlocked_atoms(const Net& net, const rt::Core& core) {
  BIP_ASSERT(net.too_large_atom == kNoRow, "atom {} has too many local states", net.too_large_atom);
  BIP_ASSERT(net.system->atoms.size() == core.image().atoms.size, "net and image of different systems");
  const std::size_t count = net.graph.nodes.size();
  const u32 ports = net.graph.port_count();
  std::vector<std::uint8_t> is_on(ports, 0), is_stuck(net.mode_base.size() - 1, 1), ready(count, 0),
      in_context(count, 0);
  for (u32 port = 0; port < ports; ++port) {
    const u32 atom = net.graph.atom_of_port[port];
    is_on[port] = core.enabled_transition(atom, port - net.graph.port_base[atom]) != rt::kNone ? 1 : 0;
  }
  for (bool changed = true; changed;) {
    changed = false;
    // Children come before parents.
    for (u32 row = 0; row < count; ++row) {
      const Node& node = net.graph.nodes[row];
      if (node.kind == ConnectorNodeKind::Port) {
        // Who is not stuck may offer anything one day.
        ready[row] = is_stuck[net.graph.atom_of_port[row]] == 0 || is_on[row] != 0 ? 1 : 0;
      } else {
        bool all = true, any = false;
        for (const Edge& child : net.graph.children(row)) {
          all = all && ready[child.node] != 0;
          any = any || (ready[child.node] != 0 && (node.kind == ConnectorNodeKind::Any || child.is_trigger));
        }
        ready[row] = (node.kind == ConnectorNodeKind::All ? all : any) ? 1 : 0;
      }
      in_context[row] = 0;
    }
    for (u32 row = static_cast<u32>(count); row-- > 0;) {
      if (net.graph.nodes[row].is_root) in_context[row] = 1;
      if (in_context[row] == 0 || ready[row] == 0) continue;
      for (const Edge& child : net.graph.children(row)) in_context[child.node] = 1;
      if (net.graph.nodes[row].kind != ConnectorNodeKind::Port) continue;
      std::uint8_t& stuck = is_stuck[net.graph.atom_of_port[row]];
      changed = changed || stuck != 0;
      stuck = 0;
    }
  }
  std::vector<u32> stuck;
  for (u32 atom = 0; atom < is_stuck.size(); ++atom) {
    if (is_stuck[atom] != 0 && rt::wants_to_move(core, atom)) stuck.push_back(atom);
  }
  return stuck;
}

}  // namespace bip::verify
