// Time in the core: clocks, bounds of conditions as intervals of instants, invariants that bound the time spent,
// `resume`.
//
// What is enabled is still a matter of one instant. A timed atom's ports are found for `now`, and with them the next
// instant at which they may change and the last one that its invariants allow; `advance` goes to an instant and looks
// at those atoms again whose ports may have changed. Everything between atoms (connectors, priorities, maximal
// progress) is as without time, so a dominated interaction is hidden at exactly those instants at which a dominating
// one is enabled.
#include <algorithm>
#include <cmath>

#include "runtime/core/core.hpp"

namespace bip::rt {

namespace {

// A value in a clock's unit, to the nearest tick. False: not a number, or beyond what a clock counts.
bool to_ticks(double value, i64 unit, i64& ticks) {
  const double exact = value * static_cast<double>(unit);
  if (!(std::fabs(exact) <= static_cast<double>(kMaxTicks))) return false;
  // The range first: beyond it the conversion is undefined. Truncated by hand, for std::floor may be a call.
  if (std::fabs(value) <= 9007199254740992.0) {
    const auto whole = static_cast<i64>(value);
    if (static_cast<double>(whole) == value) {
      ticks = whole * unit;
      return true;
    }
  }
  ticks = static_cast<i64>(std::llround(exact));
  return true;
}

// May what it offers later be said now? Not if C++ is asked: it may answer otherwise next time.
bool is_foreseeable(const AtomType& type, const Image& image) {
  if (type.time->events.size != 0 || type.priorities.size != 0) return false;
  const auto is_simple = [&](const TimeGuard& when) {
    if (image.ffi != nullptr && when.measure != kNone) return false;
    return std::all_of(when.bounds.begin(), when.bounds.end(), [](const Bound& bound) { return bound.minus == kNone; });
  };
  for (u32 row = 0; row < type.transitions.size; ++row) {
    if (image.ffi != nullptr && type.transitions[row].guard != kNone) return false;
    if (!is_simple(type.time->transitions[row].when)) return false;
  }
  return std::all_of(type.time->invariants.begin(), type.time->invariants.end(), is_simple);
}

TypeTime time_of_type(const AtomType& type, const Image& image) {
  TypeTime out;
  out.time = type.time;
  if (type.time == nullptr) return out;
  out.has_resume = type.time->initial.present;
  for (const TransitionTime& transition : type.time->transitions) out.has_resume |= transition.resume.present;
  for (const TimeGuard& invariant : type.time->invariants) out.has_limits |= invariant.bounds.size != 0;
  out.is_foreseeable = is_foreseeable(type, image);
  return out;
}

}  // namespace

bool has_time(const Image& image) {
  for (const Atom& atom : image.atoms) {
    if (image.atom_types[atom.type].time != nullptr) return true;
  }
  return false;
}

void Core::build_time() {
  const Image& image = *tables_.image;
  if (!has_time(image)) return;
  time_ = std::make_unique<TimeState>();
  u32 clocks = 0;
  for (const Atom& atom : image.atoms) {
    time_->clock_base.push_back(clocks);
    const AtomTime* time = image.atom_types[atom.type].time;
    if (time == nullptr) continue;
    clocks += time->clocks.size;
    for (const TransitionTime& transition : time->transitions) {
      if (transition.async.present && time_->at_work.empty()) time_->at_work.resize(image.atoms.size);
    }
    for (const Clock& clock : time->clocks) {
      if (time_->unit == 0 || clock.unit < time_->unit) time_->unit = clock.unit;
    }
  }
  time_->clock_base.push_back(clocks);
  if (time_->unit == 0) time_->unit = 1'000'000'000;
  list_event_ports();
  for (const AtomType& type : image.atom_types) time_->types.push_back(time_of_type(type, image));
  for (const ConnectorType& type : image.connector_types) time_->has_sync |= type.resume_sync;
}

void Core::forget_time() {
  TimeState& t = *time_;
  t.now = 0;
  t.clocks.assign(t.clock_base.back(), {});
  t.busy_until.assign(atoms_.size, 0);
  t.may_resume_until.assign(atoms_.size, kForever);
  t.ports.assign(ports_.size(), {});
  t.coming.assign(atoms_.size, {});
  t.queues.assign(t.event_ports.size(), {});
  t.set_clocks.clear();
  t.at_work.assign(t.at_work.size(), {});
  t.working.clear();
  t.changes.reset(atoms_.size);
  t.ends.reset(atoms_.size);
}

Int128 Core::clock_value(u32 atom, u32 clock) const {
  const ClockState& state = time_->clocks[time_->clock_base[atom] + clock];
  return state.value + run_for(state.speed, time_->now - state.since);
}

void Core::start_clocks(u32 atom) {
  const AtomTime* time = tables_.atom_type(atom).time;
  if (time == nullptr) return;
  Cell* self = all_.data() + atoms_[atom].first_cell;
  for (const Clock& clock : time->clocks) self[clock.variable + 2].f = 1.0;
}

// Takes what an action said of the clocks out of the hidden variables.
bool Core::read_clocks(u32 atom, const Transition* fired) {
  const AtomTime* time = time_->types[atoms_[atom].type].time;
  if (time == nullptr) return true;
  Cell* self = all_.data() + atoms_[atom].first_cell;
  ClockState* states = time_->clocks.data() + time_->clock_base[atom];
  for (u32 row = 0; row < time->clocks.size; ++row) {
    const Clock& clock = time->clocks[row];
    ClockState& state = states[row];
    const double speed = self[clock.variable + 2].f;
    const bool is_as_ever = speed == 1.0 && state.speed == kUnitSpeed;
    if (!is_as_ever && speed != static_cast<double>(state.speed) / static_cast<double>(kUnitSpeed)) {
      if (!(speed >= 0 && speed <= static_cast<double>(kMaxSpeed / kUnitSpeed)))
        return fail_clock(atom, clock, fired, "speed", speed);
      const Int128 value = clock_value(atom, row);
      if (value > kMaxTicks)
        return fail_clock(atom, clock, fired, "value", static_cast<double>(value) / static_cast<double>(clock.unit));
      state = {static_cast<i64>(value), time_->now, std::llround(speed * static_cast<double>(kUnitSpeed))};
      self[clock.variable + 2].f = static_cast<double>(state.speed) / static_cast<double>(kUnitSpeed);
    }
    if (self[clock.variable + 1].i == 0) continue;
    const double value = self[clock.variable].f;
    self[clock.variable] = self[clock.variable + 1] = Cell{0};
    time_->set_clocks.push_back(time_->clock_base[atom] + row);
    if (!to_ticks(value, clock.unit, state.value)) return fail_clock(atom, clock, fired, "value", value);
    state.since = time_->now;
  }
  return true;
}

// The limits that are no constants, into their hidden variables.
bool Core::measure_limits(u32 atom, const TimeGuard& when) {
  const Code measure = tables_.code(when.measure);
  if (measure.fn == nullptr) return true;
  const std::int32_t status = measure.fn(measure.context, all_.data() + atoms_[atom].first_cell, all_.data(), nullptr);
  return status < 2 || fail_code(status, atom, kNone, nullptr, "a limit of a clock");
}

// Takes a measured limit out of its variable. False: it is no number, and compares with nothing.
bool Core::take_limit(u32 atom, const Bound& bound, i64& limit) {
  limit = bound.ticks;
  if (bound.variable == kNone) return true;
  Cell* self = all_.data() + atoms_[atom].first_cell;
  const double value = self[bound.variable].f;
  self[bound.variable] = Cell{0};
  // What is beyond all clocks is still above or below them.
  if (!to_ticks(value, time_->types[atoms_[atom].type].time->clocks[bound.clock].unit, limit))
    limit = value > 0 ? kMaxTicks : -kMaxTicks;
  return !std::isnan(value);
}

// The instants from now on at which all bounds hold.
bool Core::interval_of(u32 atom, const TimeGuard& when, Interval& out) {
  const i64 now = time_->now;
  out = {now, kForever, false, false};
  if (when.bounds.size == 0) return true;
  if (when.measure != kNone && !measure_limits(atom, when)) return false;
  const ClockState* states = time_->clocks.data() + time_->clock_base[atom];
  for (const Bound& bound : when.bounds) {
    i64 limit = bound.ticks;
    if (bound.variable != kNone && !take_limit(atom, bound, limit)) out = Interval::none();
    const ClockState& clock = states[bound.clock];
    i64 at = 0;
    if (bound.minus == kNone && clock.speed == kUnitSpeed && !__builtin_sub_overflow(limit, clock.value, &at) &&
        !__builtin_add_overflow(at, clock.since, &at) && at > -kMaxTicks && at < kMaxTicks) {
      if (bound.op == BoundOp::Ge) {
        // As most conditions are.
        if (at > out.low) out.low = at, out.low_open = false;
      } else {
        out.meet(instants_around(now, at, bound.op));
      }
      continue;
    }
    Int128 value = clock_value(atom, bound.clock);
    i64 speed = clock.speed;
    if (bound.minus != kNone) {
      value -= clock_value(atom, bound.minus);
      speed -= states[bound.minus].speed;
    }
    out.meet(instants_of(now, value, speed, bound.op, limit));
  }
  return true;
}

bool Core::resume_interval(u32 atom, const Resume& resume, Interval& out) {
  if (!interval_of(atom, resume.when, out)) return false;
  const Code guard = tables_.code(resume.guard);
  if (guard.fn == nullptr) return true;
  const std::int32_t status = guard.fn(guard.context, all_.data() + atoms_[atom].first_cell, all_.data(), nullptr);
  if (status >= 2) return fail_code(status, atom, kNone, nullptr, "what `resume` waits for");
  if (status == 0) out = Interval::none();
  return true;
}

// After a step of the atom, internal transitions included: how long is it busy? fired: null for `initial`.
bool Core::begin_resume(u32 atom, const LinkedTransition* fired) {
  time_->busy_until[atom] = 0;
  time_->may_resume_until[atom] = kForever;
  const TypeTime& type = time_->types[atoms_[atom].type];
  if (!type.has_resume) return true;
  const AtomTime* time = type.time;
  const u32 first = tables_.types[atoms_[atom].type].first_transition;
  const Resume& resume = fired == nullptr
                             ? time->initial
                             : time->transitions[static_cast<u32>(fired - tables_.transitions.data()) - first].resume;
  if (!resume.present) return true;
  Interval interval;
  if (!resume_interval(atom, resume, interval)) return false;
  time_->busy_until[atom] = interval.empty() ? kForever : interval.low;
  time_->may_resume_until[atom] = interval.high;
  return true;
}

// The ports of one interaction go on together, at the first instant at which all may; without one, never.
bool Core::resume_together(std::vector<u32>& rows) {
  i64 until = 0, last = kForever;
  // Who is at work goes on by itself.
  rows.erase(std::remove_if(rows.begin(), rows.end(), [this](u32 atom) { return is_at_work(atom); }), rows.end());
  for (const u32 atom : rows) {
    until = std::max(until, time_->busy_until[atom]);
    last = std::min(last, time_->may_resume_until[atom]);
  }
  if (until > last) until = kForever;
  for (const u32 atom : rows) {
    if (time_->busy_until[atom] == until) continue;
    time_->busy_until[atom] = until;
    if (!look_at_time(atom)) return false;
  }
  return true;
}

// now; of each clock its value and speed; of each atom the instant until which it is busy; who is at work, and at what;
// of each port for events how many wait, and their values.
void Core::save_time(std::vector<i64>& out) const {
  out.push_back(time_->now);
  for (u32 atom = 0; atom < atoms_.size; ++atom) {
    for (u32 clock = 0; clock < time_->clock_base[atom + 1] - time_->clock_base[atom]; ++clock) {
      out.push_back(static_cast<i64>(clock_value(atom, clock)));
      out.push_back(time_->clocks[time_->clock_base[atom] + clock].speed);
    }
    out.push_back(std::max(time_->busy_until[atom], time_->now));
  }
  for (const u32 atom : time_->working) {
    const AtWork& work = time_->at_work[atom];
    for (const i64 word : {i64{atom}, i64{work.transition}, i64{work.place}, work.until, i64{work.is_overrun}})
      out.push_back(word);
  }
  if (has_async()) out.push_back(-1);
  for (const EventQueue& queue : time_->queues) {
    out.push_back(queue.count);
    for (std::size_t k = queue.first; k < queue.values.size(); ++k)
      out.push_back(static_cast<i64>(queue.values[k].bits));
  }
}

void Core::load_time(const std::vector<i64>& in) {
  time_->set_clocks.clear();
  const i64* next = in.data();
  time_->now = *next++;
  for (u32 atom = 0; atom < atoms_.size; ++atom) {
    for (u32 clock = time_->clock_base[atom]; clock < time_->clock_base[atom + 1]; ++clock, next += 2)
      time_->clocks[clock] = {next[0], time_->now, next[1]};
    time_->busy_until[atom] = *next++;
  }
  time_->at_work.assign(time_->at_work.size(), {});
  time_->working.clear();
  for (; has_async() && *next >= 0; next += 5) {
    time_->working.push_back(static_cast<u32>(next[0]));
    time_->at_work[time_->working.back()] = {static_cast<u32>(next[1]), static_cast<u32>(next[2]), next[3], 0,
                                             next[4] != 0};
  }
  if (has_async()) ++next;
  for (u32 row = 0; row < time_->queues.size(); ++row) {
    EventQueue& queue = time_->queues[row];
    queue = {static_cast<u32>(*next++), 0, {}};
    for (u32 k = 0; k < queue.count * time_->event_ports[row].width; ++k)
      queue.values.push_back(Cell{.bits = static_cast<u64>(*next++)});
  }
}

}  // namespace bip::rt
