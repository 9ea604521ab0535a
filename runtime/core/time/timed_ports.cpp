// Timed atoms at an instant: what their ports offer, when that changes next, how long candidates may wait, and a timed
// step.
//
// An atom is looked at when it has moved and when its ports may change by themselves. A periodic atom's only change is
// that the port it waits for becomes enabled: a look foresees that, interval and all, so that to let time pass
// evaluates nothing. Cost of a step: one look at each atom that took part, O(log atoms) for each instant that is kept.
#include <algorithm>

#include "runtime/core/state/flip.hpp"

namespace bip::rt {

// A timed atom's ports at this instant, and what is next.
bool Core::look_at_time(u32 atom) {
  TimeState& t = *time_;
  const bool is_busy = t.busy_until[atom] > t.now;
  if (!is_busy && is_at_work(atom)) return finish_action(atom);
  const AtomInfo& state = atoms_[atom];
  const LinkedType& type = tables_.types[state.type];
  const TypeTime& rules = t.types[state.type];
  const AtomTime& time = *rules.time;
  const u32 ports = tables_.port_base(atom + 1) - state.port_base;
  u32* now = port_scratch_.data();
  for (u32 port = 0; port < ports; ++port) now[port] = kNone;
  i64 next = is_busy ? t.busy_until[atom] : kForever;
  u32 possible = 0;
  Coming& coming = t.coming[atom];
  coming.transition = kNone;
  const bool is_automaton = type.mark_words == 0;
  // Of automata those that leave the place, of others all.
  const Span<u32> leaving = is_automaton ? tables_.place_transitions[type.first_place + places_[atom]]
                                         : Span<u32>{nullptr, type.transition_count};
  for (u32 k = 0; k < leaving.size && !is_busy; ++k) {
    const u32 row = is_automaton ? leaving[k] : type.first_transition + k;
    const LinkedTransition& transition = tables_.transitions[row];
    if (!is_automaton && transition.port == kNone) continue;
    const TransitionTime& timing = time.transitions[row - type.first_transition];
    bool is_enabled = true;
    if ((!is_automaton || transition.guard.fn != nullptr) && !is_enabled_from(atom, transition, is_enabled))
      return false;
    if (!is_enabled || is_without_event(state.port_base + transition.port)) continue;
    Interval interval;
    if (!interval_of(atom, timing.when, interval)) return false;
    if (interval.empty()) continue;
    ++possible;
    if (interval.low > t.now) {
      next = std::min(next, interval.low);
      coming = {row, timing.urgency, interval};
      continue;
    }
    if (interval.high != kForever) next = std::min(next, interval.high + 1);
    PortTime& port = t.ports[state.port_base + transition.port];
    if (now[transition.port] != kNone) {
      port.other = row;
      port.interval.meet(interval);
      port.urgency = std::max(port.urgency, timing.urgency);
      continue;
    }
    now[transition.port] = row;
    port = {interval, timing.urgency, kNone};
  }
  if (time.events.size != 0 && !refuse_events(atom, now)) return false;
  if (type.has_priorities && !hide_ports(atom, now)) return false;
  for (u32 port = 0; port < ports; ++port) set_port(state.port_base + port, now[port]);
  t.changes.set(atom, next);
  if (possible != 1 || !rules.is_foreseeable) coming.transition = kNone;
  for (u32 clock = t.clock_base[atom]; clock < t.clock_base[atom + 1]; ++clock) {
    // Values of others are rounded at the instant of a look.
    if (t.clocks[clock].speed != kUnitSpeed) coming.transition = kNone;
  }
  return !rules.has_limits || look_at_invariants(atom);
}

// What a look would find: the interval of the one transition that was waited for has begun, all else is as it was,
// invariants included.
inline void Core::enable_coming(u32 atom) {
  TimeState& t = *time_;
  Coming& coming = t.coming[atom];
  const u32 instance = atoms_[atom].port_base + tables_.transitions[coming.transition].port;
  t.ports[instance] = {coming.interval, coming.urgency, kNone};
  t.changes.set(atom, coming.interval.high == kForever ? kForever : coming.interval.high + 1);
  set_port(instance, coming.transition);
  coming.transition = kNone;
}

// The last instant that the invariants of the atom's places allow: no time passes where one does not hold.
bool Core::look_at_invariants(u32 atom) {
  const AtomType& type = tables_.atom_type(atom);
  i64 end = kForever;
  // What bounds the time at work is the budget.
  for (u32 row = is_at_work(atom) ? type.invariants.size : 0; row < type.invariants.size; ++row) {
    if (type.time->invariants[row].bounds.size == 0 || !is_in_scope(atom, type.invariants[row])) continue;
    Interval interval;
    if (!interval_of(atom, type.time->invariants[row], interval)) return false;
    end = std::min(end, interval.has(time_->now) ? interval.high : time_->now);
  }
  time_->ends.set(atom, end);
  return true;
}

bool Core::advance(i64 to) {
  TimeState& t = *time_;
  t.now = to;
  while (t.changes.first_key() <= to) {
    const u32 atom = t.changes.first_row();
    if (t.coming[atom].transition != kNone && t.coming[atom].interval.low == to) enable_coming(atom);
    else if (!look_at_time(atom)) return false;
  }
  return dirty_.empty() && dirty_rules_.empty() ? true : settle();
}

i64 Core::time_unit() const { return time_->unit; }

CandidateTime Core::time_of(const Candidate& candidate) {
  CandidateTime out{{time_->now, kForever, false, false}, Urgency::Lazy};
  // Ports of other atoms have no limits.
  const auto meet = [&](u32 instance) {
    const PortTime& port = time_->ports[instance];
    out.interval.meet(port.interval);
    out.urgency = std::max(out.urgency, port.urgency);
  };
  const InteractionInfo info = tables_.interactions[candidate.interaction];
  if (info.kind == InteractionKind::Port) {
    meet(info.row);
  } else if (info.kind == InteractionKind::Flat) {
    for (u32 i = 0; i < info.count; ++i) meet(tables_.flat_ports[info.first + i]);
  } else {
    participants(candidate, participant_scratch_);
    for (const Participant& participant : participant_scratch_)
      meet(tables_.instance(participant.atom, participant.port));
  }
  return out;
}

// Before a step in which the port takes part. False: it is a fault.
inline bool Core::begin_timed(u32 instance) {
  const PortState& port = ports_[instance];
  if (const u32 other = time_->ports[instance].other; other != kNone) {
    return fail(FaultCode::TwoTransitions, tables_.port_atom[instance], tables_.transitions[port.transition].source,
                tables_.transitions[other].source);
  }
  if (!time_->event_row.empty()) take_event(instance);
  return true;
}

bool Core::take_timed(EnabledSet::Position at) {
  time_->set_clocks.clear();
  const InteractionInfo info = tables_.interactions[at.interaction];
  const bool is_sync =
      time_->has_sync && info.kind != InteractionKind::Port && tables_.connector_type(info.row).resume_sync;
  if (info.kind == InteractionKind::Port) return begin_timed(info.row) && take(at);
  if (info.kind == InteractionKind::Flat && !is_sync) {
    const u32* ports = tables_.flat_ports.data() + info.first;
    bool is_timed = false;
    for (u32 i = 0; i < info.count; ++i) {
      if (!begin_timed(ports[i])) return false;
      is_timed = is_timed || ports_[ports[i]].place == kNone;
    }
    // Where places do not say all there is no program: not asked for again.
    if (!is_timed) return take(at);
    remember(at.interaction);
    return fire_flat(info) && settle();
  }
  const Candidate chosen = candidate(at);
  participants(chosen, participant_scratch_);
  std::vector<u32> together;
  for (const Participant& participant : participant_scratch_) {
    if (is_sync && time_->types[atoms_[participant.atom].type].time != nullptr) together.push_back(participant.atom);
    if (!begin_timed(tables_.instance(participant.atom, participant.port))) return false;
  }
  if (!fire(chosen)) return false;
  if (together.size() < 2) return true;
  if (!resume_together(together)) return false;
  return dirty_.empty() && dirty_rules_.empty() ? true : settle();
}

// An eager candidate lets no time pass, a delayable one none beyond its last instant.
i64 Core::wait_limit(std::vector<i64>& ends) {
  i64 last = last_instant();
  ends.clear();
  for (u64 k = 0; k < candidate_count(); ++k) {
    const CandidateTime time = time_of(candidate(k));
    ends.push_back(time.interval.high);
    if (time.urgency == Urgency::Eager) last = now();
    else if (time.urgency == Urgency::Delayable) last = std::min(last, time.interval.high);
  }
  return std::max(last, now());
}

}  // namespace bip::rt
