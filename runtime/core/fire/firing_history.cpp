// See firing_history.hpp.
#include "runtime/core/fire/firing_history.hpp"

#include "bip/assert.hpp"

namespace bip::rt {

std::vector<InteractionId> FiringHistory::recent(u64 count) const {
  BIP_ASSERT(count <= kSize, "{} of the last {} interactions", count, kSize);
  std::vector<InteractionId> interactions;
  interactions.reserve(count);
  for (u64 i = count; i > 0; --i) interactions.push_back(InteractionId(ring_[(at_ + kSize - i) % kSize]));
  return interactions;
}

std::vector<InteractionId> FiringHistory::last_of_atoms(const Tables& tables) const {
  std::vector<InteractionId> last(tables.image->atoms.size);
  for (u32 i = 0; i < kSize; ++i) {
    const InteractionId interaction(ring_[(at_ + i) % kSize]);
    BIP_ASSERT(!interaction.is_valid() || tables.interactions.contains(interaction), "interaction {} of {}",
               interaction, tables.interactions.size());
    if (!interaction.is_valid()) continue;
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
