// See partial.hpp. Everything here is called by one thread at a time; only the actions of works run elsewhere. Cost: as
// a step of the core's rules, plus the groups of the atoms that take part.
#include "runtime/core/fire/partial.hpp"

#include <algorithm>
#include <utility>

#include "bip/assert.hpp"
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
  if (!plan.witnesses.empty()) return false;
  const auto first = tables.plan_uses.begin() + plan.first_use;
  return std::none_of(first, first + plan.use_count,
                      [&](const PlanUse& use) { return can_fault(tables, use.connector); });
}

}  // namespace

void ports_of_interaction(const Tables& tables, const InteractionInfo& info, std::vector<u32>& out) {
  out.clear();
  if (info.kind == InteractionKind::Port) out.push_back(info.row);
  for (u32 i = 0; i < info.count; ++i) out.push_back(tables.flat_ports[info.first + i]);
  if (info.plan() == kNone) return;
  const Plan& plan = tables.plans[info.plan()];
  for (u32 i = 0; i < plan.node_count; ++i) {
    const PlanNode& node = tables.plan_nodes[plan.first_node + i];
    if (node.kind == NodeKind::Leaf) out.push_back(node.ref);
  }
}

void atoms_of_interaction(const Tables& tables, const InteractionInfo& info, std::vector<u32>& out) {
  ports_of_interaction(tables, info, out);
  for (u32& port : out) port = tables.port_atom[port];
  std::sort(out.begin(), out.end());
}

PartialState link_partial(const Tables& tables, const PriorityTables& rules) {
  PartialState p;
  const u32 interaction_count = static_cast<u32>(tables.interactions.size());
  std::vector<Csr::Pair> atom_groups;
  std::vector<RowsByInteraction::Pair> interaction_atoms, interaction_groups;
  std::vector<std::uint8_t> is_strict;
  std::vector<u32> atoms;
  p.own_group.assign(interaction_count, kNone);
  p.is_exclusive.assign(interaction_count, 0);
  for (const InteractionId interaction : tables.interactions.ids()) {
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
    // Rules that decide about connectors below it read data of others.
    const u32 plan = tables.is_of_connector(interaction) ? info.plan() : kNone;
    if (plan == kNone || tables.plans[plan].witnesses.empty()) continue;
    for (u32 atom = 0; atom < tables.image->atoms.size; ++atom) {
      const Span<InteractionId> watchers = tables.atom_watch[atom];
      if (std::find(watchers.begin(), watchers.end(), interaction) != watchers.end())
        atom_groups.push_back({atom, group});
    }
  }
  p.atoms_of_interaction = RowsByInteraction::build(interaction_count, interaction_atoms);

  const u32 components = static_cast<u32>(rules.cyclic.size());
  for (u32 component = 0; component < components; ++component) {
    p.group_of_component.push_back(static_cast<u32>(is_strict.size()));
    is_strict.push_back(0);
  }
  for (u32 rule = 0; rule < rules.count; ++rule) {
    const u32 group = p.group_of_component[rules.component[rule]];
    if (tables.image->priorities[rule].guard != kNone) is_strict[group] = 1;
    for (const InteractionId interaction : rules.interactions_of_low[rule])
      interaction_groups.push_back({interaction, group});
  }
  for (const HighEdge& edge : rules.high_edges) {
    const u32 group = p.group_of_component[rules.component[edge.rule]];
    for (const u32 atom : p.atoms_of_interaction[edge.interaction]) atom_groups.push_back({atom, group});
  }
  for (u32 atom = 0; rules.count != 0 && atom < tables.image->atoms.size; ++atom) {
    for (const u32 rule : tables.atom_rules[atom])
      atom_groups.push_back({atom, p.group_of_component[rules.component[rule]]});
  }
  Csr::sort_unique(atom_groups);
  p.groups_of_atom = Csr::build(tables.image->atoms.size, atom_groups);
  for (const InteractionId interaction : tables.interactions.ids()) {
    for (const u32 atom : p.atoms_of_interaction[interaction]) {
      for (const u32 group : p.groups_of_atom[atom]) {
        if (is_strict[group] != 0) interaction_groups.push_back({interaction, group});
      }
    }
  }
  RowsByInteraction::sort_unique(interaction_groups);
  p.groups_of_interaction = RowsByInteraction::build(interaction_count, interaction_groups);
  p.busy_in_group.assign(is_strict.size(), 0);
  p.last_step.assign(tables.image->atoms.size, 0);
  p.order.assign(tables.image->atoms.size, 0);
  BIP_ASSERT(std::all_of(interaction_groups.begin(), interaction_groups.end(),
                         [&](const RowsByInteraction::Pair& pair) { return pair.to < is_strict.size(); }),
             "a group beyond {}", is_strict.size());
  BIP_ASSERT(p.group_of_component.size() == components, "{} groups of {} components", p.group_of_component.size(),
             components);
  return p;
}

void PartialSteps::allow() {
  core_.memory.binds.make(*core_.tables.image);
  BIP_ASSERT(core_.is_settled(), "partial states are of settled systems");
  state_ = std::make_unique<PartialState>(link_partial(core_.tables, core_.priorities.tables()));
}

bool PartialSteps::end() {
  BIP_ASSERT(
      std::all_of(state_->busy_in_group.begin(), state_->busy_in_group.end(), [](u32 busy) { return busy == 0; }),
      "a group still counts atoms at work");
  BIP_ASSERT(state_->busy == 0, "{} atoms are at work", state_->busy);
  core_.fault = std::move(state_->fault);
  state_.reset();
  return !core_.fault;
}

bool PartialSteps::is_decided(InteractionId interaction) const {
  const PartialState& p = *state_;
  if (p.busy == 0) return true;
  if (p.is_exclusive[interaction] != 0) return false;
  for (const u32 group : p.groups_of_interaction[interaction]) {
    if (p.busy_in_group[group] != 0) return false;
  }
  return true;
}

// Of two faults the one that a sequential run meets first.
void PartialSteps::note_fault(u64 step, u32 order) {
  PartialState& p = *state_;
  p.noted = true;
  if (p.fault && (p.fault_step < step || (p.fault_step == step && p.fault_order <= order))) return;
  p.fault = core_.fault;
  p.fault_step = step;
  p.fault_order = order;
}

bool PartialSteps::begin(EnabledSet::Position at, u64 step, std::vector<Work>& works) {
  PartialState& p = *state_;
  BIP_ASSERT(core_.enabled.has(at) && is_decided(at.interaction), "interaction {} may not begin", at.interaction);
  p.step = step;
  p.begun = 0;
  p.works = &works;
  p.noted = false;
  is_beginning_ = p.is_exclusive[at.interaction] == 0;
  core_.fault = {};
  if (!is_beginning_) {
    for (const u32 atom : p.atoms_of_interaction[at.interaction]) p.last_step[atom] = step;
  }
  const bool sound = core_.firing.fire(core_.candidate(at));
  is_beginning_ = false;
  if (!sound && !p.noted) note_fault(step, p.begun);
  return sound;
}

bool PartialSteps::take_whole(EnabledSet::Position at, u64 step) {
  PartialState& p = *state_;
  BIP_ASSERT(core_.enabled.has(at) && p.groups_of_interaction[at.interaction].size == 0 && !is_beginning_,
             "interaction {} is not taken as a whole", at.interaction);
  p.step = step;
  p.noted = false;
  // No guard waits for these atoms and no other node gets their offers: their last steps are never read.
  if (core_.fault) core_.fault = {};
  const bool is_sound = core_.firing.take(at);
  if (!is_sound && !p.noted) note_fault(step, 0);
  return is_sound;
}

// From now on the atom offers nothing. A simple type's ports follow its place, so it is nowhere.
void PartialSteps::withdraw(u32 atom) {
  const AtomInfo& info = core_.atoms[atom];
  const LinkedType& type = core_.tables.types[info.type];
  if (!state_->rest.empty()) state_->rest[atom] = core_.memory.places[atom];
  if (type.simple) {
    for (const u32 row : core_.tables.place_transitions[type.first_place + core_.memory.places[atom]])
      core_.ports.flip(info.port_base + core_.tables.transitions[row].port, false);
    core_.memory.places[atom] = kNone;
  } else {
    for (u32 port = info.port_base; port < core_.tables.port_base(atom + 1); ++port) core_.ports.set_port(port, kNone);
    if (type.is_timed) core_.clocks.forget(atom);
  }
}

void PartialSteps::occupy(u32 atom) {
  PartialState& p = *state_;
  ++p.busy;
  p.most_busy = std::max(p.most_busy, p.busy);
  for (const u32 group : p.groups_of_atom[atom]) ++p.busy_in_group[group];
}

void PartialSteps::release(u32 atom) {
  PartialState& p = *state_;
  BIP_ASSERT(p.busy != 0, "atom {} is not at work", atom);
  --p.busy;
  for (const u32 group : p.groups_of_atom[atom]) {
    BIP_ASSERT(p.busy_in_group[group] != 0, "no atom of group {} is at work", group);
    --p.busy_in_group[group];
  }
}

bool PartialSteps::begin_port(u32 instance) {
  PartialState& p = *state_;
  const u32 atom = core_.tables.port_atom[instance];
  const LinkedType& type = core_.tables.types[core_.atoms[atom].type];
  const LinkedTransition& transition = core_.tables.transitions[core_.ports.port(instance).transition];
  if (type.is_timed && !core_.clocks.begin_port(instance)) return false;
  withdraw(atom);
  p.last_step[atom] = p.step;
  BIP_ASSERT(p.works != nullptr && is_beginning_, "a port fires outside of a step");
  p.order[atom] = p.begun;
  if (!type.simple && !core_.atom_steps.move_tokens(atom, transition)) return false;
  occupy(atom);
  ++p.begun;
  p.works->push_back({.atom = atom, .transition = &transition, .step = p.step});
  return true;
}

// How the work's action runs beside the others from now on; null: it runs now.
const Async* PartialSteps::async_of(const Work& work) const {
  const bool is_timed = core_.tables.types[core_.atoms[work.atom].type].is_timed;
  if (!is_timed || work.is_return || work.internals != 0 || !core_.actions.any()) return nullptr;
  return core_.actions.async_of(work.atom, *work.transition);
}

std::int32_t PartialSteps::run(const Work& work) {
  if (async_of(work) != nullptr) return 1;
  const bool is_timed = core_.tables.types[core_.atoms[work.atom].type].is_timed;
  // What runs beside the others was shown them when it began.
  if (is_timed && (!work.is_return || work.internals != 0)) core_.clocks.show_clocks(work.atom);
  const Code& action = work.transition->action;
  return action.fn == nullptr ? 1
                              : action.fn(action.context, core_.memory.cells.from(core_.atoms[work.atom].first_cell),
                                          core_.memory.cells.all(), nullptr);
}

Finished PartialSteps::come_to_rest(Work& work, std::int32_t status) {
  PartialState& p = *state_;
  const u32 atom = work.atom;
  const LinkedType& type = core_.tables.types[core_.atoms[atom].type];
  BIP_ASSERT(p.busy != 0, "atom {} ends, and {} are at work", atom, p.busy);
  BIP_ASSERT(!type.simple || core_.memory.places[atom] == kNone, "atom {} is at place {} while it works", atom,
             core_.memory.places[atom]);
  if (type.simple) core_.memory.places[atom] = work.transition->to;
  core_.fault = {};
  p.noted = false;
  p.step = work.step;
  bool sound = status < 2 || core_.faults.fail_code(status, atom, kNone, work.transition->source);
  if (sound && type.is_timed) {
    core_.clocks.begin_part();
    if (const Async* const async = async_of(work)) {
      const u32 from = type.mark_words == 0 ? work.transition->from : core_.memory.places[atom];
      core_.actions.begin_work(atom, *work.transition, *async, from);
      return Finished::Idle;
    }
    sound = core_.clocks.read_clocks(atom, work.transition->source);
  }
  if (sound && !type.fixed) {
    const LinkedTransition* next = nullptr;
    sound = (!type.has_invariants || core_.atom_steps.check_invariants(atom, work.transition)) &&
            (!type.has_internal || core_.atom_steps.find_internal(atom, next));
    if (sound && next != nullptr) {
      if (work.internals++ >= core_.options.internal_bound) {
        sound = core_.faults.fail(FaultCode::EndlessInternals, atom, next->source, nullptr);
      } else if (core_.atom_steps.move_tokens(atom, *next)) {
        if (work.fired == nullptr) work.fired = work.transition;
        work.transition = next;
        return Finished::More;
      } else {
        sound = false;
      }
    }
  }
  if (sound && type.is_timed)
    sound = core_.clocks.begin_resume(atom, work.fired != nullptr ? work.fired : work.transition);
  if (sound) return Finished::Idle;
  note_fault(p.last_step[atom], p.order[atom]);
  return Finished::Fault;
}

bool PartialSteps::offer_here(u32 atom) {
  const bool sound = core_.atom_steps.update_ports(atom, kNone);
  release(atom);
  if (!sound) {
    note_fault(state_->last_step[atom], state_->order[atom]);
    return false;
  }
  if (core_.atoms[atom].watched != 0) core_.ports.touch(atom);
  return settle();
}

Finished PartialSteps::finish(Work& work, std::int32_t status) {
  const Finished how = come_to_rest(work, status);
  if (how == Finished::More) return how;
  if (how == Finished::Fault) {
    release(work.atom);
    return how;
  }
  return offer_here(work.atom) ? Finished::Idle : Finished::Fault;
}

// No step has an atom twice (alternatives that could are excluded before), so none has to be alone.
void PartialSteps::share() {
  PartialState& p = *state_;
  p.rest.assign(core_.tables.image->atoms.size, kNone);
  std::fill(p.is_exclusive.begin(), p.is_exclusive.end(), std::uint8_t{0});
}

void PartialSteps::send_away(u32 atom) {
  BIP_ASSERT(!state_->rest.empty(), "atom {} leaves a core that is alone", atom);
  withdraw(atom);
  occupy(atom);
}

// What settle() held stays marked, so it comes back when it is looked at. All others follow their ports at once.
void PartialSteps::drop_held() {
  for (const InteractionId interaction : core_.ports.dirty()) {
    BIP_ASSERT(!is_decided(interaction), "interaction {} is decided and was not looked at", interaction);
    core_.enabled.set(interaction, 0);
  }
  core_.enabled.settle_list();
}

u32 PartialSteps::place_at_rest(u32 atom) const {
  const u32 place = core_.memory.places[atom];
  return place != kNone || state_->rest.empty() ? place : state_->rest[atom];
}

bool PartialSteps::take_up(u32 atom, u32 transition, u64 step, u32 order, Work& work) {
  PartialState& p = *state_;
  const LinkedTransition& row = core_.tables.transitions[transition];
  const LinkedType& type = core_.tables.types[core_.atoms[atom].type];
  BIP_ASSERT(!type.simple || p.rest[atom] == row.from, "atom {} leaves place {}, and is at {}", atom, row.from,
             p.rest[atom]);
  p.last_step[atom] = step;
  p.order[atom] = order;
  work = {.atom = atom, .transition = &row, .step = step};
  core_.fault = {};
  p.noted = false;
  const bool is_sound = !type.is_timed || core_.clocks.begin_port(core_.tables.instance(atom, row.port));
  if (is_sound && (type.simple || core_.atom_steps.move_tokens(atom, row))) {
    if (type.is_timed) core_.clocks.forget(atom);
    return true;
  }
  note_fault(step, order);
  return false;
}

void PartialSteps::begin_change(u32 atom, u64 step) {
  PartialState& p = *state_;
  p.step = p.last_step[atom] = step;
  // Atoms whose ports change at one instant are looked at in this order.
  p.order[atom] = atom;
}

Work PartialSteps::return_action(u32 atom) {
  return {
      .atom = atom, .transition = &core_.actions.end_work(atom), .step = state_->last_step[atom], .is_return = true};
}

bool PartialSteps::change_here(u32 atom) {
  core_.fault = {};
  state_->noted = false;
  if (core_.clocks.look_at_time(atom)) {
    if (core_.atoms[atom].watched != 0) core_.ports.touch(atom);
    return true;
  }
  note_fault(state_->last_step[atom], state_->order[atom]);
  return false;
}

bool PartialSteps::find_enabled_ports(u32 atom, std::vector<u32>& ports) {
  ports.clear();
  if (!core_.atom_steps.find_ports(atom)) {
    note_fault(state_->last_step[atom], state_->order[atom]);
    return false;
  }
  const u32 count = core_.tables.port_base(atom + 1) - core_.tables.port_base(atom);
  for (u32 port = 0; port < count; ++port) {
    if (core_.atom_steps.port_scratch()[port] != kNone) ports.push_back(port);
  }
  return true;
}

bool PartialSteps::offer_away(u32 atom, AtomOffer& offer) {
  PartialState& p = *state_;
  const LinkedType& type = core_.tables.types[core_.atoms[atom].type];
  if (!core_.atom_steps.find_ports(atom)) {
    note_fault(p.last_step[atom], p.order[atom]);
    return false;
  }
  offer.place = core_.memory.places[atom];
  const u64* marks = core_.memory.marks.data() + core_.tables.first_mark(atom);
  offer.marks.assign(marks, marks + type.mark_words);
  offer.transitions.clear();
  offer.times.clear();
  const u32 ports = core_.tables.port_base(atom + 1) - core_.tables.port_base(atom);
  for (u32 port = 0; port < ports; ++port) {
    const u32 row = core_.atom_steps.port_scratch()[port];
    if (row == kNone) continue;
    offer.transitions.push_back(row);
    if (!type.is_timed) continue;
    // Of two transitions of a port the home makes a fault, which has the data.
    offer.times.push_back(core_.clocks.port_time(core_.tables.port_base(atom) + port));
    offer.times.back().other = kNone;
  }
  if (type.is_timed) offer.change = core_.clocks.next_change_of(atom);
  offer.step = p.last_step[atom];
  offer.order = p.order[atom];
  p.rest[atom] = offer.place;
  if (type.simple) core_.memory.places[atom] = kNone;
  return true;
}

bool PartialSteps::receive(u32 atom, const AtomOffer& offer) {
  PartialState& p = *state_;
  const AtomInfo& info = core_.atoms[atom];
  const LinkedType& type = core_.tables.types[info.type];
  core_.fault = {};
  p.noted = false;
  p.step = p.last_step[atom] = offer.step;
  p.order[atom] = offer.order;
  core_.memory.places[atom] = offer.place;
  std::copy(offer.marks.begin(), offer.marks.end(), core_.memory.marks.begin() + core_.tables.first_mark(atom));
  BIP_ASSERT(offer.times.size() == (type.is_timed ? offer.transitions.size() : 0), "{} times of {} ports",
             offer.times.size(), offer.transitions.size());
  for (std::size_t k = 0; k < offer.times.size(); ++k)
    core_.clocks.set_port_time(info.port_base + core_.tables.transitions[offer.transitions[k]].port, offer.times[k]);
  if (type.is_timed) core_.clocks.expect_change(atom, offer.change);
  for (const u32 row : offer.transitions) {
    const u32 port = info.port_base + core_.tables.transitions[row].port;
    if (type.simple) core_.ports.flip(port, true);
    else core_.ports.set_port(port, row);
  }
  release(atom);
  if (info.watched != 0) core_.ports.touch(atom);
  return settle();
}

// The step that brought the interaction's atoms where they are.
u64 PartialSteps::last_step_of(InteractionId interaction) const {
  u64 last = 0;
  for (const u32 atom : state_->atoms_of_interaction[interaction]) last = std::max(last, state_->last_step[atom]);
  return last;
}

// As settle; what depends on atoms at work waits. A fault does not end it: an earlier step's may follow.
bool PartialSteps::settle() {
  PartialState& p = *state_;
  core_.ports.dirty().hold([&](InteractionId interaction) {
    const u32 group = p.own_group[interaction];
    return group != kNone && p.busy_in_group[group] != 0;
  });
  core_.priorities.dirty().hold(
      [&](u32 rule) { return p.busy_in_group[p.group_of_component[core_.priorities.tables().component[rule]]] != 0; });
  bool sound = true;
  for (const InteractionId interaction : core_.ports.dirty()) {
    if (!core_.search.is_searched(interaction) || core_.search.list(interaction)) continue;
    note_fault(last_step_of(interaction), kAfterAll);
    sound = false;
  }
  if (sound && core_.priorities.tables().count != 0) {
    sound = core_.priorities.settle();
    // Groups of guards are strict: their last step is the one that just ended.
    if (!sound) note_fault(p.step, kAfterAll);
  } else if (sound) {
    for (const InteractionId interaction : core_.ports.dirty())
      core_.enabled.set(interaction, core_.search.base_count(interaction));
  }
  core_.ports.dirty().clear();
  core_.ports.dirty().release();
  core_.priorities.dirty().release();
  core_.enabled.settle_list();
  return sound;
}

}  // namespace bip::rt
