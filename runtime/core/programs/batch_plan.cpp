// See batch_plan.hpp.
#include "runtime/core/programs/batch_plan.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/fire/partial.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kMostPairs = std::size_t{1} << 26;  // (interaction, atom) pairs that are looked at

}  // namespace

std::vector<std::uint8_t> parts_of_atoms(const RowsByInteraction& atoms_of_interaction,
                                         const InteractionsBy& interactions_of_atom, u32 atoms, u32 parts) {
  std::vector<u32> order;
  std::vector<std::uint8_t> is_met(atoms, 0);
  IndexVector<InteractionId, std::uint8_t> is_walked(atoms_of_interaction.first.size(), 0);
  order.reserve(atoms);
  for (u32 root = 0; root < atoms; ++root) {
    if (is_met[root] != 0) continue;
    is_met[root] = 1;
    order.push_back(root);
    for (std::size_t at = order.size() - 1; at < order.size(); ++at) {
      for (const InteractionId interaction : interactions_of_atom[order[at]]) {
        if (is_walked[interaction] != 0) continue;
        is_walked[interaction] = 1;
        for (const u32 next : atoms_of_interaction[interaction]) {
          if (is_met[next] != 0) continue;
          is_met[next] = 1;
          order.push_back(next);
        }
      }
    }
  }
  BIP_ASSERT(order.size() == atoms, "{} of {} atoms", order.size(), atoms);
  std::vector<std::uint8_t> part(atoms, 0);
  for (u32 i = 0; i < atoms; ++i) part[order[i]] = static_cast<std::uint8_t>(u64{i} * parts / atoms);
  return part;
}

BatchPlan plan_batch(const Tables& tables, const PriorityTables& rules, u32 parts, bool any_share) {
  BatchPlan plan;
  const u32 interaction_count = static_cast<u32>(tables.interactions.size());
  const u32 atom_count = tables.image->atoms.size;
  // What an interaction's being enabled depends on: who takes part; if rules may hide it, who takes part in what they
  // prefer.
  std::vector<RowsByInteraction::Pair> own, all;
  std::vector<u32> atoms;
  for (const InteractionId interaction : tables.interactions.ids()) {
    atoms_of_interaction(tables, tables.interactions[interaction], atoms);
    for (const u32 atom : atoms) own.push_back({interaction, atom});
  }
  const RowsByInteraction takes = RowsByInteraction::build(interaction_count, own);
  all = own;
  std::vector<std::vector<u32>> preferred(rules.cyclic.size());  // by component
  for (const HighEdge& edge : rules.high_edges) {
    std::vector<u32>& of = preferred[rules.component[edge.rule]];
    of.insert(of.end(), takes[edge.interaction].begin(), takes[edge.interaction].end());
  }
  for (std::vector<u32>& of : preferred) {
    std::sort(of.begin(), of.end());
    of.erase(std::unique(of.begin(), of.end()), of.end());
  }
  for (u32 rule = 0; rule < rules.count; ++rule) {
    for (const InteractionId interaction : rules.interactions_of_low[rule]) {
      for (const u32 atom : preferred[rules.component[rule]]) all.push_back({interaction, atom});
      if (all.size() > kMostPairs) return plan;
    }
  }
  const RowsByInteraction depends = RowsByInteraction::build(interaction_count, all);
  const InteractionsBy watchers = depends.transposed(atom_count);
  const std::vector<std::uint8_t> part_of_atom = parts_of_atoms(depends, watchers, atom_count, parts);

  IndexVector<InteractionId, std::uint8_t> spans(interaction_count, 0);
  plan.part.assign(interaction_count, 0);
  plan.is_shared.assign(interaction_count, 0);
  plan.size.assign(parts, 0);
  for (const InteractionId interaction : tables.interactions.ids()) {
    const Span<u32> on = depends[interaction];
    plan.part[interaction] = on.size == 0 ? 0 : part_of_atom[on[0]];
    ++plan.size[plan.part[interaction]];
    for (const u32 atom : on) {
      if (part_of_atom[atom] != plan.part[interaction]) spans[interaction] = 1;
    }
  }
  // An atom is at the border if something that watches it spans; what moves such an atom is shared.
  std::vector<std::uint8_t> is_border(atom_count, 0);
  for (const InteractionId interaction : tables.interactions.ids()) {
    for (const u32 atom : depends[interaction]) {
      if (spans[interaction] != 0) is_border[atom] = 1;
    }
  }
  for (const InteractionId interaction : tables.interactions.ids()) {
    const Span<u32> moved = takes[interaction];
    if (std::none_of(moved.begin(), moved.end(), [&](u32 atom) { return is_border[atom] != 0; })) continue;
    plan.is_shared[interaction] = 1;
    plan.shared.push_back(interaction);
  }
  BIP_ASSERT(std::is_sorted(plan.shared.begin(), plan.shared.end()), "{} shared interactions", plan.shared.size());
  if (any_share || plan.shared.size() * 4 <= interaction_count) plan.parts = parts;
  return plan;
}

}  // namespace bip::rt
