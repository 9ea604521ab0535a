// Describes one interaction as operations: its code, the next places of its atoms, and the interactions that it may
// enable or disable.
//
// Supported: rendezvous of atoms of simple types (one transition per port, without guards), flat or in a hierarchy
// without triggers; guards of flat connectors; internal ports; broadcasts of atoms; code that cannot fault. Since
// nothing faults and the code of different atoms or connectors shares no variables, `up`s run bottom up, `down`s top
// down, then actions: this order forms loops, unlike the core's depth-first order, and gives the same result.
// Hierarchies: transfers.cpp.
#include <algorithm>

#include "compiler/steps/deriver.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::steps {

using rt::InteractionKind;

Deriver::Deriver(const lower::LoweredSystem& lowered)
    : lowered_(lowered),
      image_(lowered.image),
      tables_(rt::link(image_, rt::MaximalProgress::On)),
      rules_(rt::link_priorities(tables_)),
      values_(lowered.system->code, image_.cell_count) {
  binds_.make(image_);
  for (const lower::CodeUnit& unit : lowered.units)
    facts_.push_back(lower::code_facts(lowered.system->code, unit.expr, unit.body));
  for (u32 type = 0; type < image_.atom_types.size; ++type) {
    const rt::LinkedType& linked = tables_.types[type];
    first_port_.push_back(static_cast<u32>(transitions_.size()));
    transitions_.resize(transitions_.size() + image_.atom_types[type].ports.size, kNone);
    if (!linked.simple) continue;
    for (u32 row = linked.first_transition; row < linked.first_transition + linked.transition_count; ++row) {
      transitions_[first_port_[type] + tables_.transitions[row].port] = row;
    }
  }
}

u32 Deriver::transition_of(u32 instance) const {
  const u32 atom = tables_.port_atom[instance];
  BIP_ASSERT(tables_.types[tables_.atoms[atom].type].simple, "port {} is of no simple type", instance);
  return transitions_[first_port_[tables_.atoms[atom].type] + instance - tables_.port_base(atom)];
}

bool Deriver::have_distinct_atoms() {
  atoms_.clear();
  for (const u32 port : ports_) atoms_.push_back(tables_.port_atom[port]);
  std::sort(atoms_.begin(), atoms_.end());
  return std::adjacent_find(atoms_.begin(), atoms_.end()) == atoms_.end();
}

bool Deriver::add_code(u32 unit, u32 zeroed, u32 self, u32 binds, Instance& out) {
  if (unit != kNone && facts_[unit].may_fault) return false;
  BIP_ASSERT(unit == kNone || unit < facts_.size(), "unit {} of {}", unit, facts_.size());
  StepOp& op = out.add(StepOpKind::Code);
  op.unit = unit;
  op.zeroed = zeroed;
  out.ref(self);
  if (unit == kNone) return true;
  for (const u32 bound : facts_[unit].binds) out.ref(binds_.rows[binds + bound]);
  return true;
}

bool Deriver::add_connector_codes(const rt::InteractionInfo& info, Instance& out) {
  if (info.clause() == kNone) return true;
  const rt::Connector& row = image_.connectors[info.row];
  const rt::ConnectorType& type = tables_.connector_type(info.row);
  const rt::Clause& clause = type.clauses[info.clause()];
  if (clause.may_fault || (clause.guard != kNone && facts_[clause.guard].may_fault)) return false;
  u32 zeroed = type.variables.size;
  for (const u32 unit : {clause.up, clause.down}) {
    if (unit == kNone) continue;
    if (!add_code(unit, zeroed, row.first_cell, row.binds, out)) return false;
    zeroed = 0;
  }
  return true;
}

// Places, then actions: an action sees data alone.
bool Deriver::add_actions(Instance& out) {
  for (const u32 port : ports_) {
    const rt::LinkedTransition& transition = tables_.transitions[transition_of(port)];
    if (transition.source->action == kNone) continue;
    if (!add_code(transition.source->action, 0, tables_.atoms[tables_.port_atom[port]].first_cell.value, 0, out))
      return false;
  }
  for (const u32 port : ports_) {
    const rt::LinkedTransition& transition = tables_.transitions[transition_of(port)];
    if (transition.from == transition.to) continue;
    out.add(StepOpKind::Place);
    out.ref(tables_.port_atom[port]);
    out.ref(transition.to);
  }
  return true;
}

Deriver::Found Deriver::describe(rt::InteractionId interaction, Instance& out) {
  const rt::InteractionInfo info = tables_.interactions[interaction];
  BIP_ASSERT(tables_.interactions.contains(interaction), "interaction {} of {}", interaction,
             tables_.interactions.size());
  out.clear();
  ports_.clear();
  if (info.kind == InteractionKind::Planned) {
    const rt::Plan& plan = tables_.plans[info.plan()];
    if (info.searched || !plan.rigid || plan.guarded || plan.has_choice) return Found::No;
    for (u32 i = 0; i < plan.node_count; ++i) {
      const rt::PlanNode& node = tables_.plan_nodes[plan.first_node + i];
      if (node.kind == rt::NodeKind::Leaf) ports_.push_back(node.ref);
    }
  } else if (info.kind == InteractionKind::Port) {
    ports_.push_back(info.row);
  } else {
    for (u32 i = 0; i < info.count; ++i) ports_.push_back(tables_.flat_ports[info.first + i]);
  }
  for (const u32 port : ports_) {
    const u32 atom = tables_.port_atom[port];
    if (!tables_.types[tables_.atoms[atom].type].simple) return Found::No;
    // A port without a transition: never ready. In a broadcast others go on without it; those are rare.
    if (transition_of(port) == kNone) return info.kind == InteractionKind::Star ? Found::No : Found::Never;
  }
  if (!have_distinct_atoms()) return Found::No;
  bool done = false;
  switch (info.kind) {
    case InteractionKind::Flat:
      done = add_connector_codes(info, out) && add_actions(out) && add_effects(interaction, out);
      break;
    case InteractionKind::Planned:
      done = add_plan_codes(tables_.plans[info.plan()], out) && add_actions(out) && add_effects(interaction, out);
      break;
    case InteractionKind::Port: done = add_actions(out) && add_effects(interaction, out); break;
    case InteractionKind::Star: done = add_star(interaction, info, out); break;
  }
  return done ? Found::Yes : Found::No;
}

}  // namespace bip::steps
