// See node.hpp.
#include "runtime/distributed/node.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "bip/assert.hpp"

namespace bip::rt {

bool Node::start(const State& state) {
  const u32 atoms = core_.image().atoms.size;
  participations_.assign(atoms, 0);
  BIP_ASSERT(distribution_.history.empty() || distribution_.history.size() == atoms, "{} atoms have a history",
             distribution_.history.size());
  history_ = distribution_.history;
  history_.resize(atoms, kNone);
  if (!core_.restore(state)) return false;
  moment_ = {core_.now(), 0};
  PartialSteps& partial = core_.partial();
  partial.allow();
  partial.share();
  start_actions();
  for (u32 atom = 0; atom < atoms; ++atom) {
    u32 coordinator = kNone;
    if (!find_coordinator(atom, coordinator, offered_for_[atom])) return false;
    where_[atom] = coordinator == self_ ? Where::Here : Where::Away;
    is_in_core_[atom] = coordinator == self_ ? 1 : 0;
    if (coordinator == self_) continue;
    partial.send_away(atom);
    // The home knows when it offers something else.
    const bool is_timed = core_.tables().types[core_.tables().atoms[atom].type].is_timed;
    if (is_timed && distribution_.home(atom) == self_ && !partial.find_enabled_ports(atom, enabled_)) return false;
  }
  if (!partial.settle()) return false;
  // The restored state had candidates of all interactions, and other nodes coordinate most of them.
  partial.drop_held();
  start_locks();
  link_whole();
  link_compiled();
  return true;
}

// Of a resumed state: an action beside the others is its home's. They have begun before all steps, in this order.
void Node::start_actions() {
  const std::vector<u32> working = core_.actions().working();
  for (std::size_t k = 0; k < working.size(); ++k) {
    if (distribution_.home(working[k]) == self_) core_.partial().note_begun(working[k], static_cast<u32>(k));
    else (void)core_.actions().end_work(working[k]);
  }
}

void Node::take(const Message& message) {
  std::visit([this](const auto& said) { take(said); }, message);
  serve();
  land_evaluated();
}

// What may fault looks at a group of atoms, and waits until all of them are at rest here. So does each interaction of
// one of these atoms: between its step and the evaluation none of them moves.
void Node::land_evaluated() {
  if (is_stopped_) return;
  std::erase_if(unevaluated_, [this](const Unevaluated& at) {
    if (!core_.partial().is_decided(at.interaction)) return false;
    landed_.push_back(at.step);
    return true;
  });
}

void Node::forget_lost(u32 node) {
  std::erase_if(unevaluated_, [&](const Unevaluated& at) {
    const Span<u32> atoms = core_.partial().state()->atoms_of_interaction[at.interaction];
    if (std::none_of(atoms.begin(), atoms.end(), [&](u32 atom) { return distribution_.home(atom) == node; }))
      return false;
    landed_.push_back(at.step);
    return true;
  });
}

// An instant begins when all nodes rest and nothing is on its way, so no message of an earlier one comes after it.
void Node::pass_to(Moment moment) {
  if (moment.instant <= moment_.instant) return;
  if (!works_.empty()) {
    ++counts_.refused;
    return;
  }
  moment_ = moment;
  changed_.clear();
  core_.time().pass_to(moment.instant, changed_);
  for (const u32 atom : changed_) change(atom);
  if (!core_.partial().settle()) stop();
}

// What the atom offered holds no longer.
void Node::change(u32 atom) {
  PartialSteps& partial = core_.partial();
  const bool is_home = distribution_.home(atom) == self_;
  if (is_home) {
    ++participations_[atom];
    partial.begin_change(atom, moment_.step);
  }
  const bool returns = is_home && core_.actions().is_at_work(atom) && core_.time().busy_until(atom) <= moment_.instant;
  if (is_home && !returns && is_in_core_[atom] != 0) {
    if (!partial.change_here(atom)) stop();
    return;
  }
  if (is_in_core_[atom] != 0) {
    BIP_ASSERT(where_[atom] == Where::Here, "atom {} is offered here and is elsewhere", atom);
    partial.send_away(atom);
    where_[atom] = Where::Away;
    is_in_core_[atom] = 0;
  }
  if (returns) {
    where_[atom] = Where::Working;
    works_.push_back(partial.return_action(atom));
  } else if (is_home) {
    come_to_rest(atom);
  }
}

void Node::take(const Offer& offer) {
  pass_to(offer.moment);
  if (offer.n <= participations_[offer.atom]) {
    ++counts_.stale;
    return;
  }
  if (is_in_core_[offer.atom] != 0 || distribution_.home(offer.atom) == self_) {
    ++counts_.refused;
    return;
  }
  receive(offer);
  note_change(offer.atom);
}

void Node::receive(const Offer& offer) {
  BIP_ASSERT(distribution_.home(offer.atom) != self_, "atom {} is at home here", offer.atom);
  participations_[offer.atom] = offer.n;
  where_[offer.atom] = Where::Here;
  is_in_core_[offer.atom] = 1;
  offered_for_[offer.atom] = offer.set;
  const Span<VariableId> cells = distribution_.cells[offer.atom];
  BIP_ASSERT(cells.size == offer.cells.size(), "{} of {} variables", offer.cells.size(), cells.size);
  for (u32 i = 0; i < cells.size; ++i) core_.write_cell(cells[i], offer.cells[i]);
  tell(NodeEvent::Kind::Received, offer.atom);
  if (!core_.partial().receive(offer.atom, offer.offer)) stop();
}

// The atom is at rest here, and offered elsewhere or locked for the interaction.
bool Node::may_take_up(const Part& part, InteractionId interaction) const {
  const u32 atom = part.atom;
  if (distribution_.home(atom) != self_ || part.n != participations_[atom] || is_in_core_[atom] != 0) return false;
  const bool is_locked_for_it = where_[atom] == Where::Locked && taken_by_[atom] == interaction;
  if (where_[atom] != Where::Away && !is_locked_for_it) return false;
  const Tables& tables = core_.tables();
  const bool is_automaton = tables.types[tables.atoms[atom].type].mark_words == 0;
  return !is_automaton || core_.partial().place_at_rest(atom) == tables.transitions[part.transition].from;
}

void Node::take(const Begin& begin) {
  pass_to(begin.moment);
  for (const Part& part : begin.parts) {
    if (part.n < participations_[part.atom]) {
      ++counts_.stale;
      continue;
    }
    if (!may_take_up(part, begin.interaction)) {
      ++counts_.refused;
      continue;
    }
    ++participations_[part.atom];
    where_[part.atom] = Where::Working;
    tell(NodeEvent::Kind::Taken, part.atom, begin.interaction);
    const Span<VariableId> cells = distribution_.cells[part.atom];
    for (u32 i = 0; i < cells.size; ++i) core_.write_cell(cells[i], part.cells[i]);
    note_history(part.atom, core_.tables().transitions[part.transition], begin.interaction);
    Work work;
    if (core_.partial().take_up(part.atom, part.transition, begin.step, part.order, work)) works_.push_back(work);
    else stop();
  }
  if (has_split() && distribution_.coordinator_of[begin.interaction] == self_) note_success(begin.interaction);
}

bool Node::begin(EnabledSet::Position at, u64 step, std::vector<u32>& atoms) {
  BIP_ASSERT(core_.partial().is_decided(at.interaction), "interaction {} waits for atoms elsewhere", at.interaction);
  begun_.clear();
  if (!core_.partial().begin(at, step, begun_)) stop();
  const std::size_t first = outbox_.size();
  u32 order = 0;
  for (const Work& work : begun_) {
    const u32 home = distribution_.home(work.atom);
    atoms.push_back(work.atom);
    BIP_ASSERT(is_in_core_[work.atom] != 0, "atom {} takes part and is not offered here", work.atom);
    where_[work.atom] = home == self_ ? Where::Working : Where::Away;
    is_in_core_[work.atom] = 0;
    tell(NodeEvent::Kind::Begun, work.atom, at.interaction);
    if (home == self_) {
      tell(NodeEvent::Kind::Taken, work.atom, at.interaction);
      ++participations_[work.atom];
      note_history(work.atom, *work.transition, at.interaction);
      works_.push_back(work);
      ++order;
      continue;
    }
    std::size_t to = first;
    while (to < outbox_.size() && outbox_[to].to != home) ++to;
    if (to == outbox_.size()) {
      outbox_.push_back({home, Begin{step, {}, at.interaction, moment_}});
      ++counts_.begins;
    }
    Part part{work.atom,
              participations_[work.atom],
              static_cast<u32>(work.transition - core_.tables().transitions.data()),
              order++,
              {}};
    for (const VariableId cell : distribution_.cells[work.atom]) part.cells.push_back(core_.cell(cell).bits);
    std::get<Begin>(outbox_[to].message).parts.push_back(std::move(part));
  }
  const bool is_evaluated_here =
      distribution_.may_fault && core_.partial().state()->groups_of_interaction[at.interaction].size != 0;
  if (is_evaluated_here) unevaluated_.push_back({step, at.interaction});
  if (ready_.empty()) return is_evaluated_here;
  BIP_ASSERT(at.interaction == ready_.front().interaction, "interaction {} begins before {}, of which all is locked",
             at.interaction, ready_.front().interaction);
  // What the coordinator of the attempt gets back comes before its BEGIN.
  const auto begins = static_cast<std::ptrdiff_t>(first), end_of_begins = static_cast<std::ptrdiff_t>(outbox_.size());
  end_attempt();
  std::rotate(outbox_.begin() + begins, outbox_.begin() + end_of_begins, outbox_.end());
  serve();
  return is_evaluated_here;
}

// Left out, as their steps have more than atoms that act: models with time, and nodes that lock.
void Node::link_whole() {
  const Tables& tables = core_.tables();
  const PartialState& partial = *core_.partial().state();
  whole_steps_.assign(static_cast<u32>(tables.interactions.size()), WholeSteps::None);
  has_whole_ = false;
  if (core_.is_timed() || has_split()) return;
  // By atom: is it at home on this node, are all of its interactions coordinated here, and do no guards of other
  // interactions read its data?
  std::vector<std::uint8_t> stays(core_.image().atoms.size, 0);
  const ConflictSets& sets = distribution_.sets;
  const auto is_here = [this](u32 node) { return node == self_ || node == kNone; };
  for (u32 atom = 0; atom < stays.size(); ++atom) {
    if (distribution_.home(atom) != self_ || partial.groups_of_atom[atom].size != 0) continue;
    const auto first = distribution_.offered_at.begin();
    const bool is_offered_here =
        sets.by_situation[atom] != 0 ||
        std::all_of(first + sets.first_place[atom], first + sets.first_place[atom + 1], is_here);
    stays[atom] = is_offered_here ? 1 : 0;
  }
  for (std::size_t row = 0; row < sets.situations.size(); ++row) {
    const u32 atom = sets.situations[row].atom;
    if (sets.by_situation[atom] != 0 && !is_here(distribution_.offered_in[row])) stays[atom] = 0;
  }
  for (const InteractionId interaction : tables.interactions.ids()) {
    const InteractionInfo info = tables.interactions[interaction];
    const Span<u32> ports = ports_of_whole(info);
    if (distribution_.coordinator_of[interaction] != self_ || partial.own_group[interaction] != kNone ||
        partial.groups_of_interaction[interaction].size != 0 || ports.size == 0)
      continue;
    const Span<u32> atoms = partial.atoms_of_interaction[interaction];
    if (!std::all_of(atoms.begin(), atoms.end(), [&](u32 atom) { return stays[atom] != 0; })) continue;
    const bool is_told_apart =
        std::any_of(ports.begin(), ports.end(), [&](u32 port) { return sets.is_told_apart[port] != 0; });
    whole_steps_[interaction] = is_told_apart ? WholeSteps::WithHistory : WholeSteps::Plain;
    has_whole_ = true;
  }
}

// Not with rules: compiled steps do not keep up what rules hide.
void Node::link_compiled() {
  const CompiledSteps& steps = core_.steps();
  has_compiled_ = false;
  is_all_compiled_ = true;
  compiled_histories_ = 0;
  history_noted_.assign(core_.image().atoms.size, 0);
  noting_ = 1;
  if (!steps.has_steps() || core_.priorities().count != 0 || !core_.enabled().is_listed()) return;
  is_compiled_.assign(static_cast<u32>(whole_steps_.size()), 0);
  for (const InteractionId interaction : core_.tables().interactions.ids()) {
    if (distribution_.coordinator_of[interaction] != self_) continue;
    if (whole_steps_[interaction] == WholeSteps::None || !steps.has_step(interaction)) {
      is_all_compiled_ = false;
      continue;
    }
    is_compiled_[interaction] = 1;
    has_compiled_ = true;
    if (whole_steps_[interaction] != WholeSteps::WithHistory) continue;
    const InteractionInfo info = core_.tables().interactions[interaction];
    for (const u32 port : ports_of_whole(info)) {
      u64& is_counted = history_noted_[core_.tables().port_atom[port]];
      if (distribution_.sets.is_told_apart[port] == 0 || is_counted == noting_) continue;
      is_counted = noting_;
      ++compiled_histories_;
    }
  }
}

u64 Node::take_compiled(Prng& prng, u64 limit, InteractionId& drawn) {
  BIP_ASSERT(has_compiled(), "{} steps without compiled code", limit);
  limit = std::min(limit, kMostCompiled);
  drawn = {};
  bool is_sound = true;
  const u64 done = is_all_compiled_ ? core_.steps().run(
                                          prng, limit, [] { return false; }, is_sound)
                                    : core_.steps().run_among(is_compiled_, prng, limit, drawn);
  BIP_ASSERT(is_sound, "a compiled step of {} met a fault", done);
  if (compiled_histories_ != 0) note_last_histories(done);
  return done;
}

// note_histories of the steps that the core took last: backwards, as the last one of each atom tells.
void Node::note_last_histories(u64 steps) {
  BIP_ASSERT(steps <= FiringHistory::kSize, "{} steps", steps);
  const Tables& tables = core_.tables();
  const FiringHistory& fired = core_.history();
  ++noting_;
  u32 left = compiled_histories_;
  for (u64 k = 0; k < steps && left != 0; ++k) {
    const InteractionId interaction = fired.before_last(k);
    if (whole_steps_[interaction] != WholeSteps::WithHistory) continue;
    const InteractionInfo info = tables.interactions[interaction];
    for (const u32 port : ports_of_whole(info)) {
      const u32 atom = tables.port_atom[port];
      if (distribution_.sets.is_told_apart[port] == 0 || history_noted_[atom] == noting_) continue;
      history_noted_[atom] = noting_;
      history_[atom] = tables.connector_of(interaction);
      --left;
    }
  }
}

Span<u32> Node::ports_of_whole(const InteractionInfo& info) const {
  return info.kind == InteractionKind::Port ? Span<u32>{&info.row, 1} : core_.tables().fixed_ports(info);
}

bool Node::take_whole(EnabledSet::Position at, u64 step) {
  const InteractionId interaction = at.interaction;
  BIP_ASSERT(is_whole(interaction), "interaction {} is not taken as a whole", interaction);
  if (whole_steps_[interaction] == WholeSteps::WithHistory) note_histories(interaction);
  if (core_.partial().take_whole(at, step)) return true;
  stop();
  return false;
}

void Node::note_histories(InteractionId interaction) {
  const Tables& tables = core_.tables();
  const InteractionInfo info = tables.interactions[interaction];
  for (const u32 port : ports_of_whole(info)) {
    if (distribution_.sets.is_told_apart[port] != 0)
      history_[tables.port_atom[port]] = tables.connector_of(interaction);
  }
}

void Node::note_landed(InteractionId interaction, u64 step, std::vector<u32>& atoms) {
  const Tables& tables = core_.tables();
  const InteractionInfo info = tables.interactions[interaction];
  for (const u32 port : ports_of_whole(info)) {
    atoms.push_back(tables.port_atom[port]);
    landed_.push_back(step);
  }
}

void Node::run(std::size_t k) {
  Work work = works_[k];
  BIP_ASSERT(distribution_.home(work.atom) == self_ && where_[work.atom] == Where::Working,
             "an action of atom {}, which is not at work here", work.atom);
  works_[k] = works_.back();
  works_.pop_back();
  const std::int32_t status = core_.partial().run(work);
  switch (core_.partial().come_to_rest(work, status)) {
    case Finished::More: works_.push_back(work); return;
    case Finished::Fault: stop(); break;
    case Finished::Idle: come_to_rest(work.atom); break;
  }
  // What the end of an action beside the others changes is no part of a step.
  if (!work.is_return) landed_.push_back(work.step);
  serve();
  land_evaluated();
}

// The connector, if it tells apart what may come next.
void Node::note_history(u32 atom, const LinkedTransition& transition, InteractionId interaction) {
  const Tables& tables = core_.tables();
  if (distribution_.sets.is_told_apart[tables.instance(atom, transition.port)] != 0)
    history_[atom] = tables.connector_of(interaction);
}

// Of an atom at rest: any of its enabled ports tells, if an interaction can take it through that port at all. False: a
// fault.
bool Node::find_coordinator(u32 atom, u32& coordinator, u32& set) {
  PartialSteps& partial = core_.partial();
  const u32 place = partial.place_at_rest(atom);
  set = kNone;
  if (distribution_.sets.by_situation[atom] == 0) {
    coordinator = distribution_.coordinator_at(atom, place);
    return true;
  }
  coordinator = kNone;
  if (!partial.find_enabled_ports(atom, enabled_)) return false;
  for (const u32 port : enabled_) {
    const u32 row = distribution_.sets.situation_of(atom, place, history_[atom], port);
    if (row == kNone) continue;
    // Two nodes: a peer began what no run leads to.
    if (coordinator != kNone && coordinator != distribution_.offered_in[row]) {
      ++counts_.refused;
      return true;
    }
    coordinator = distribution_.offered_in[row];
    set = distribution_.sets.situations[row].set;
  }
  return true;
}

void Node::come_to_rest(u32 atom) {
  PartialSteps& partial = core_.partial();
  tell(NodeEvent::Kind::Rested, atom, {}, partial.place_at_rest(atom));
  u32 coordinator = kNone;
  u32 set = kNone;
  if (!find_coordinator(atom, coordinator, set)) return stop();
  if (coordinator != kNone) tell(NodeEvent::Kind::Offered, atom);
  if (coordinator == self_) tell(NodeEvent::Kind::Received, atom);
  where_[atom] = coordinator == self_ ? Where::Here : Where::Away;
  is_in_core_[atom] = coordinator == self_ ? 1 : 0;
  if (has_split()) served_.push_back(atom);
  if (coordinator == self_) {
    if (!partial.offer_here(atom)) stop();
    note_change(atom);
    return;
  }
  Offer offer{atom, participations_[atom], {}, {}, moment_, set};
  if (!partial.offer_away(atom, offer.offer)) return stop();
  if (coordinator == kNone) return;
  BIP_ASSERT(coordinator < distribution_.placement.nodes.size(), "atom {} is offered to node {}", atom, coordinator);
  for (const VariableId cell : distribution_.cells[atom]) offer.cells.push_back(core_.cell(cell).bits);
  outbox_.push_back({coordinator, std::move(offer)});
  ++counts_.offers;
}

// Of all faults the one of the earliest step is the run's; the others only have to stop.
void Node::stop() {
  is_stopped_ = true;
  const u64 step = core_.partial().state()->fault_step;
  for (u32 node = 0; node < distribution_.placement.nodes.size(); ++node) {
    if (node != self_) outbox_.push_back({node, Stop{step}});
  }
}

void Node::save(State& state, SavedTime& time) const {
  time.clocks.resize(core_.image().atoms.size);
  time.now = std::max(time.now, core_.now());
  const State own = core_.snapshot();
  const Image& image = core_.image();
  std::size_t object = 0;
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const bool is_home = distribution_.home(atom) == self_;
    const Tables& tables = core_.tables();
    const AtomType& type = tables.atom_type(atom);
    if (is_home && core_.is_timed()) {
      core_.time().save_atom(atom, time.clocks[atom]);
      if (core_.actions().is_at_work(atom)) {
        const PartialState& steps = *core_.partial().state();
        time.beside.push_back({steps.last_step[atom], steps.order[atom], {}});
        core_.actions().save_work(atom, time.beside.back().words);
      }
    }
    if (is_home) {
      state.places[atom] = core_.partial().place_at_rest(atom);
      const u32 words = tables.types[tables.atoms[atom].type].mark_words;
      for (u32 i = 0; i < words; ++i) state.marks[tables.first_mark(atom) + i] = own.marks[tables.first_mark(atom) + i];
    }
    for (u32 i = 0; i < type.variables.size; ++i) {
      const VariableId cell = tables.atoms[atom].first_cell + i;
      if (is_home) state.data[cell] = own.data[cell];
      if (!is_ffi(type.variables[i].type)) continue;
      if (is_home) state.objects[object] = own.objects[object];
      ++object;
    }
  }
}

void sort_by_begin(std::vector<SavedTime::Beside>& beside) {
  std::sort(beside.begin(), beside.end(), [](const SavedTime::Beside& a, const SavedTime::Beside& b) {
    return std::tuple(a.step, a.order, a.words[0]) < std::tuple(b.step, b.order, b.words[0]);
  });
}

void add_time(const Core& core, SavedTime time, State& state) {
  if (!core.is_timed()) return;
  time.clocks.resize(core.image().atoms.size);
  std::vector<i64> words{time.now}, own;
  std::size_t head = 1;
  for (u32 atom = 0; atom < time.clocks.size(); ++atom) {
    own.clear();
    core.time().save_atom(atom, own);
    head += own.size();
    const std::vector<i64>& said = time.clocks[atom].empty() ? own : time.clocks[atom];
    words.insert(words.end(), said.begin(), said.end());
  }
  // What is at work in the state before gives way; events follow.
  while (core.actions().any() && state.time[head] >= 0) head += AsyncActions::kSavedWords;
  sort_by_begin(time.beside);
  for (const SavedTime::Beside& beside : time.beside)
    words.insert(words.end(), beside.words.begin(), beside.words.end());
  words.insert(words.end(), state.time.begin() + static_cast<std::ptrdiff_t>(head), state.time.end());
  state.time = std::move(words);
}

}  // namespace bip::rt
