// Beginning and finishing steps apart: see partial.hpp. Everything here is called by one thread at a time; only the
// actions of works run elsewhere. Cost: as a step of the core's rules, plus the groups of the atoms that take part.
#include "runtime/core/fire/partial.hpp"

#include <algorithm>
#include <utility>

#include "runtime/core/state/flip.hpp"

namespace bip::rt {

namespace {

constexpr u32 kAfterAll = kNone;  // order of faults that show when all of a step's atoms are at rest

// A guard or an `up` can end in a fault, which comes when its ports are first ready in such a state.
bool can_fault(const Tables& tables, u32 connector) {
  const Span<Clause>& clauses = tables.connector_type(connector).clauses;
  return std::any_of(clauses.begin(), clauses.end(),
                     [](const Clause& clause) { return clause.may_fault || clause.guard_may_fault; });
}

bool is_plain(const Tables& tables, const InteractionInfo& info) {
  if (info.kind == InteractionKind::Port) return true;
  if (info.kind == InteractionKind::Flat) return !can_fault(tables, info.row);
  if (info.kind != InteractionKind::Planned || !tables.plans[info.plan()].rigid) return false;
  const Plan& plan = tables.plans[info.plan()];
  const auto first = tables.plan_uses.begin() + plan.first_use;
  return std::none_of(first, first + plan.use_count,
                      [&](const PlanUse& use) { return can_fault(tables, use.connector); });
}

void sort_pairs(std::vector<Csr::Pair>& pairs) {
  const auto key = [](const Csr::Pair& p) { return u64{p.from} << 32 | p.to; };
  std::sort(pairs.begin(), pairs.end(), [&](const Csr::Pair& a, const Csr::Pair& b) { return key(a) < key(b); });
  pairs.erase(
      std::unique(pairs.begin(), pairs.end(), [&](const Csr::Pair& a, const Csr::Pair& b) { return key(a) == key(b); }),
      pairs.end());
}

}  // namespace

void atoms_of_interaction(const Tables& tables, const InteractionInfo& info, std::vector<u32>& out) {
  out.clear();
  if (info.kind == InteractionKind::Port) out.push_back(tables.port_atom[info.row]);
  for (u32 i = 0; i < info.count; ++i) out.push_back(tables.port_atom[tables.flat_ports[info.first + i]]);
  if (info.plan() != kNone) {
    const Plan& plan = tables.plans[info.plan()];
    for (u32 i = 0; i < plan.node_count; ++i) {
      const PlanNode& node = tables.plan_nodes[plan.first_node + i];
      if (node.kind == NodeKind::Leaf) out.push_back(tables.port_atom[node.ref]);
    }
  }
  std::sort(out.begin(), out.end());
}

PartialState link_partial(const Tables& tables, const PriorityTables& rules) {
  PartialState p;
  const u32 cell_count = static_cast<u32>(tables.interactions.size());
  std::vector<Csr::Pair> interaction_atoms, atom_groups, interaction_groups;
  std::vector<std::uint8_t> is_strict;
  std::vector<u32> atoms;
  p.own_group.assign(cell_count, kNone);
  p.is_exclusive.assign(cell_count, 0);
  for (u32 interaction = 0; interaction < cell_count; ++interaction) {
    const InteractionInfo& info = tables.interactions[interaction];
    atoms_of_interaction(tables, info, atoms);
    const auto end = std::unique(atoms.begin(), atoms.end());
    p.is_exclusive[interaction] = end != atoms.end() ? 1 : 0;
    atoms.erase(end, atoms.end());
    for (const u32 atom : atoms) interaction_atoms.push_back({interaction, atom});
    if (is_plain(tables, info)) continue;
    const u32 group = p.own_group[interaction] = static_cast<u32>(is_strict.size());
    is_strict.push_back(info.searched ? 1 : 0);
    interaction_groups.push_back({interaction, group});
    for (const u32 atom : atoms) atom_groups.push_back({atom, group});
  }
  p.atoms_of_interaction = Csr::build(cell_count, interaction_atoms);

  const u32 components = static_cast<u32>(rules.cyclic.size());
  for (u32 component = 0; component < components; ++component) {
    p.group_of_component.push_back(static_cast<u32>(is_strict.size()));
    is_strict.push_back(0);
  }
  for (u32 rule = 0; rule < rules.count; ++rule) {
    const u32 group = p.group_of_component[rules.component[rule]];
    if (tables.image->priorities[rule].guard != kNone) is_strict[group] = 1;
    for (const u32 interaction : rules.interactions_of_low[rule]) interaction_groups.push_back({interaction, group});
  }
  for (const HighEdge& edge : rules.high_edges) {
    const u32 group = p.group_of_component[rules.component[edge.rule]];
    for (const u32 atom : p.atoms_of_interaction[edge.interaction]) atom_groups.push_back({atom, group});
  }
  for (u32 atom = 0; rules.count != 0 && atom < tables.image->atoms.size; ++atom) {
    for (const u32 item : tables.atom_watch[atom]) {
      if (item >= cell_count) atom_groups.push_back({atom, p.group_of_component[rules.component[item - cell_count]]});
    }
  }
  sort_pairs(atom_groups);
  p.groups_of_atom = Csr::build(tables.image->atoms.size, atom_groups);
  for (u32 interaction = 0; interaction < cell_count; ++interaction) {
    for (const u32 atom : p.atoms_of_interaction[interaction]) {
      for (const u32 group : p.groups_of_atom[atom]) {
        if (is_strict[group] != 0) interaction_groups.push_back({interaction, group});
      }
    }
  }
  sort_pairs(interaction_groups);
  p.groups_of_interaction = Csr::build(cell_count, interaction_groups);
  p.busy_in_group.assign(is_strict.size(), 0);
  p.last_step.assign(tables.image->atoms.size, 0);
  p.order.assign(tables.image->atoms.size, 0);
  return p;
}

void Core::allow_partial() {
  binds_.make(*tables_.image);
  partial_ = std::make_unique<PartialState>(link_partial(tables_, rules_));
}

bool Core::end_partial() {
  fault_ = std::move(partial_->fault);
  partial_.reset();
  return !fault_;
}

bool Core::is_decided(u32 interaction) const {
  const PartialState& p = *partial_;
  if (p.busy == 0) return true;
  if (p.is_exclusive[interaction] != 0) return false;
  for (const u32 group : p.groups_of_interaction[interaction]) {
    if (p.busy_in_group[group] != 0) return false;
  }
  return true;
}

// Of two faults the one that a sequential run meets first.
void Core::note_fault(u64 step, u32 order) {
  PartialState& p = *partial_;
  p.noted = true;
  if (p.fault && (p.fault_step < step || (p.fault_step == step && p.fault_order <= order))) return;
  p.fault = fault_;
  p.fault_step = step;
  p.fault_order = order;
}

bool Core::begin(EnabledSet::Position at, u64 step, std::vector<Work>& works) {
  PartialState& p = *partial_;
  p.step = step;
  p.begun = 0;
  p.works = &works;
  p.noted = false;
  collects_ = p.is_exclusive[at.interaction] == 0;
  fault_ = {};
  if (!collects_) {
    for (const u32 atom : p.atoms_of_interaction[at.interaction]) p.last_step[atom] = step;
  }
  const bool sound = fire(candidate(at));
  collects_ = false;
  if (!sound && !p.noted) note_fault(step, p.begun);
  return sound;
}

// Until it is finished the atom offers nothing. A simple type's ports follow its place, so it is nowhere.
bool Core::begin_port(u32 instance) {
  PartialState& p = *partial_;
  const u32 atom = tables_.port_atom[instance];
  const AtomInfo& info = atoms_[atom];
  const LinkedType& type = tables_.types[info.type];
  const LinkedTransition& transition = tables_.transitions[ports_[instance].transition];
  if (type.simple) {
    for (const u32 row : tables_.place_transitions[type.first_place + places_[atom]])
      flip(info.port_base + tables_.transitions[row].port, false);
    places_[atom] = kNone;
  } else {
    for (u32 port = info.port_base; port < tables_.port_base(atom + 1); ++port) set_port(port, kNone);
  }
  p.last_step[atom] = p.step;
  p.order[atom] = p.begun;
  if (!type.simple && !move_tokens(atom, transition)) return false;
  ++p.busy;
  p.most_busy = std::max(p.most_busy, p.busy);
  for (const u32 group : p.groups_of_atom[atom]) ++p.busy_in_group[group];
  ++p.begun;
  p.works->push_back({atom, &transition, 0, p.step});
  return true;
}

std::int32_t Core::run(const Work& work) {
  const Code& action = work.transition->action;
  return action.fn == nullptr
             ? 1
             : action.fn(action.context, all_.data() + atoms_[work.atom].first_cell, all_.data(), nullptr);
}

Finished Core::finish(Work& work, std::int32_t status) {
  PartialState& p = *partial_;
  const u32 atom = work.atom;
  const LinkedType& type = tables_.types[atoms_[atom].type];
  if (type.simple) places_[atom] = work.transition->to;
  fault_ = {};
  p.noted = false;
  p.step = work.step;
  bool sound = status < 2 || fail_code(status, atom, kNone, work.transition->source);
  if (sound && !type.fixed) {
    const LinkedTransition* next = nullptr;
    sound = (!type.has_invariants || check_invariants(atom, work.transition)) &&
            (!type.has_internal || find_internal(atom, next));
    if (sound && next != nullptr) {
      if (work.internals++ >= options_.internal_bound) {
        sound = fail(FaultCode::EndlessInternals, atom, next->source, nullptr);
      } else if (move_tokens(atom, *next)) {
        work.transition = next;
        return Finished::More;
      } else {
        sound = false;
      }
    }
  }
  sound = sound && update_ports(atom, kNone);
  --p.busy;
  for (const u32 group : p.groups_of_atom[atom]) --p.busy_in_group[group];
  if (!sound) {
    note_fault(p.last_step[atom], p.order[atom]);
    return Finished::Fault;
  }
  if (atoms_[atom].watched != 0) touch(atom);
  return settle_partial() ? Finished::Idle : Finished::Fault;
}

// The step that brought the interaction's atoms where they are.
u64 Core::last_step_of(u32 interaction) const {
  u64 last = 0;
  for (const u32 atom : partial_->atoms_of_interaction[interaction]) last = std::max(last, partial_->last_step[atom]);
  return last;
}

// As settle; what depends on atoms at work waits. A fault does not end it: an earlier step's may follow.
bool Core::settle_partial() {
  PartialState& p = *partial_;
  p.held_cells.clear();
  p.held_rules.clear();
  p.looked_at.clear();
  for (const u32 interaction : dirty_) {
    const u32 group = p.own_group[interaction];
    (group != kNone && p.busy_in_group[group] != 0 ? p.held_cells : p.looked_at).push_back(interaction);
  }
  dirty_.swap(p.looked_at);
  p.looked_at.clear();
  for (const u32 rule : dirty_rules_) {
    const u32 group = p.group_of_component[rules_.component[rule]];
    (p.busy_in_group[group] != 0 ? p.held_rules : p.looked_at).push_back(rule);
  }
  dirty_rules_.swap(p.looked_at);
  bool sound = true;
  for (const u32 interaction : dirty_) {
    if (listing_of(interaction) == kNone || list(interaction)) continue;
    note_fault(last_step_of(interaction), kAfterAll);
    sound = false;
  }
  if (sound && rules_.count != 0) {
    sound = settle_priorities();
    // Groups of guards are strict: their last step is the one that just ended.
    if (!sound) note_fault(p.step, kAfterAll);
  } else if (sound) {
    for (const u32 interaction : dirty_) enabled_.set(interaction, base_count(interaction));
  }
  for (const u32 interaction : dirty_) is_dirty_[interaction] = 0;
  dirty_.swap(p.held_cells);
  dirty_rules_.swap(p.held_rules);
  enabled_.settle_list();
  return sound;
}

}  // namespace bip::rt
