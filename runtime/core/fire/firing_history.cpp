// See firing_history.hpp.
#include "runtime/core/fire/firing_history.hpp"

#include "bip/assert.hpp"

namespace bip::rt {

std::vector<u32> FiringHistory::recent(u64 count) const {
  BIP_ASSERT(count <= kSize, "{} of the last {} interactions", count, kSize);
  std::vector<u32> interactions;
  for (u64 i = count; i > 0; --i) interactions.push_back(ring_[(at_ + kSize - i) % kSize]);
  return interactions;
}

std::vector<u32> FiringHistory::last_of_atoms(const Tables& tables) const {
  std::vector<u32> last(tables.image->atoms.size, kNone);
  for (u32 i = 0; i < kSize; ++i) {
    const u32 interaction = ring_[(at_ + i) % kSize];
    BIP_ASSERT(interaction == kNone || interaction < tables.interactions.size(), "interaction {} of {}", interaction,
               tables.interactions.size());
    if (interaction == kNone) continue;
    const InteractionInfo info = tables.interactions[interaction];
    if (info.kind == InteractionKind::Port) last[tables.port_atom[info.row]] = interaction;
    for (u32 port = 0; port < info.count; ++port)
      last[tables.port_atom[tables.flat_ports[info.first + port]]] = interaction;
    if (info.plan() == kNone) continue;
    const Plan& plan = tables.plans[info.plan()];
    for (u32 node = plan.first_node; node < plan.first_node + plan.node_count; ++node) {
      if (tables.plan_nodes[node].kind == NodeKind::Leaf)
        last[tables.port_atom[tables.plan_nodes[node].ref]] = interaction;
    }
  }
  return last;
}

}  // namespace bip::rt
