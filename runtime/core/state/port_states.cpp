// See port_states.hpp.
#include "runtime/core/state/port_states.hpp"

#include "bip/assert.hpp"
#include "runtime/core/state/flip.hpp"

namespace bip::rt {

void PortStates::link() {
  const Tables& tables = core_.tables;
  const PriorityTables& rules = core_.priorities.tables();
  const u32 interaction_count = static_cast<u32>(tables.interactions.size());
  ports_.resize(tables.port_atom.size());
  for (u32 atom = 0; atom < core_.atoms.size; ++atom) {
    const LinkedType& type = tables.types[tables.atoms[atom].type];
    for (u32 row = type.first_transition; type.simple && row < type.first_transition + type.transition_count; ++row) {
      PortState& port = ports_[tables.instance(atom, tables.transitions[row].port)];
      BIP_ASSERT(port.transition == kNone, "port {} of a simple type labels two transitions",
                 tables.transitions[row].port);
      port = {row, tables.transitions[row].from};
    }
  }
  const auto crossing_of = [&](InteractionId interaction) {
    if (core_.priorities.is_followed(interaction)) return Crossing::Followed;
    const bool is_ruled = rules.count != 0 && rules.is_involved[interaction] != 0;
    return is_ruled || tables.interactions[interaction].searched ? Crossing::Marked : Crossing::Direct;
  };
  while (direct_.below < interaction_count && crossing_of(InteractionId(direct_.below)) == Crossing::Direct)
    ++direct_.below;
  if (direct_.below == interaction_count) return;
  for (const InteractionId interaction : tables.interactions.ids()) direct_.of_crossing.push(crossing_of(interaction));
}

void PortStates::reset() {
  const Tables& tables = core_.tables;
  const u32 interaction_count = static_cast<u32>(tables.interactions.size());
  // Those of simple types follow their atoms' places.
  for (PortState& port : ports_) {
    if (port.place == kNone) port.transition = kNone;
  }
  values_.resize(tables.node_count());
  for (const InteractionId interaction : tables.interactions.ids())
    values_[Tables::node_of(interaction)] = tables.start_of(interaction);
  BIP_ASSERT(tables.node_count() == interaction_count + tables.inner_start.size(), "{} nodes", tables.node_count());
  std::copy(tables.inner_start.begin(), tables.inner_start.end(), values_.begin() + interaction_count);
  dirty_.reset(direct_.of_crossing.size());
  crossings_.clear();
}

bool PortStates::is_consistent() const {
  const Tables& tables = core_.tables;
  const u32 interaction_count = static_cast<u32>(tables.interactions.size());
  std::vector<std::int32_t> values(tables.node_count());
  for (const InteractionId interaction : tables.interactions.ids())
    values[Tables::node_of(interaction)] = tables.start_of(interaction);
  std::copy(tables.inner_start.begin(), tables.inner_start.end(), values.begin() + interaction_count);
  std::vector<u32> todo;  // nodes that became available
  const auto raise = [&](u32 node) {
    if (++values[node] == 0) todo.push_back(node);
  };
  for (u32 i = 0; i < ports_.size(); ++i) {
    if (enabled_row(i) == kNone) continue;
    for (const u32 node : tables.port_out[i]) raise(node);
  }
  while (!todo.empty()) {
    const u32 node = todo.back();
    todo.pop_back();
    for (const u32 above : tables.node_out[node]) raise(above);
  }
  return values == values_;
}

void PortStates::crossed(u32 node, bool on) {
  BIP_ASSERT(node < values_.size() && (values_[node] >= 0) == on, "node {} has crossed zero, its value is {}", node,
             values_[node]);
  const InteractionId interaction = Tables::interaction_at(node);
  Crossing crossing = Crossing::Direct;
  if (node >= direct_.below) {
    if (node >= direct_.of_crossing.size()) return group_crossed(node, on);
    crossing = direct_.of_crossing[interaction];
  }
  switch (crossing) {
    case Crossing::Marked: mark_dirty(interaction); return;
    case Crossing::Followed: core_.priorities.crossed(interaction, on); return;
    case Crossing::Direct:
      if (on) core_.enabled.insert(interaction);
      else core_.enabled.erase(interaction);
      return;
  }
}

void PortStates::group_crossed(u32 node, bool on) {
  const u32 interaction_count = static_cast<u32>(core_.tables.interactions.size());
  // Inner groups: iterative, for the hierarchy may be deep. Each crossing moves every counter above by one, in the same
  // direction, so the order in which crossings are worked off does not matter.
  const std::size_t bottom = crossings_.size();
  for (u32 from = node;; crossings_.pop_back()) {
    for (const u32 above : core_.tables.node_out[from]) {
      BIP_ASSERT(above < values_.size(), "node {} of {}", above, values_.size());
      const std::int32_t value = values_[above] += on ? 1 : -1;
      if (value != (on ? 0 : -1)) continue;
      if (above < interaction_count) crossed(above, on);
      else crossings_.emplace_back(above, on);
    }
    if (crossings_.size() == bottom) return;
    from = crossings_.back().first;
  }
}

// The port has flipped: marks the interactions that are searched again then.
void PortStates::mark_watching(u32 instance) {
  for (const InteractionId interaction : core_.tables.port_watch[instance]) {
    if (is_available(interaction)) mark_dirty(interaction);
  }
}

void PortStates::touch(u32 atom) {
  for (const InteractionId interaction : core_.tables.atom_watch[atom]) {
    // What is not available has nothing to evaluate; becoming available marks it.
    if (is_available(interaction)) mark_dirty(interaction);
  }
  for (const u32 rule : core_.tables.atom_rules[atom]) core_.priorities.dirty().mark(rule);
}

}  // namespace bip::rt
