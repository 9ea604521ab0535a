// See clocks.hpp.
#include "runtime/core/time/clocks.hpp"

#include <algorithm>
#include <cmath>

#include "bip/assert.hpp"
#include "bip/prng.hpp"
#include "runtime/core/state/flip.hpp"
#include "runtime/core/text.hpp"
#include "runtime/core/time/draw_instant.hpp"
#include "runtime/core/time/time_text.hpp"

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

// Has a clock of this speed values between two ticks?
bool has_fraction(i64 speed) { return (speed & (kUnitSpeed - 1)) != 0; }

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
  out.has_resume = has_resume(*type.time);
  for (const TimeGuard& invariant : type.time->invariants) out.has_limits |= invariant.bounds.size != 0;
  for (const Clock& clock : type.time->clocks) out.has_reads |= clock.is_read;
  out.is_foreseeable = is_foreseeable(type, image);
  return out;
}

}  // namespace

bool has_resume(const AtomTime& time) {
  return time.initial.present || std::any_of(time.transitions.begin(), time.transitions.end(),
                                             [](const TransitionTime& t) { return t.resume.present; });
}

bool has_time(const Image& image) {
  for (const Atom& atom : image.atoms) {
    if (image.atom_types[atom.type].time != nullptr) return true;
  }
  return false;
}

void Clocks::link() {
  const Image& image = *core_.tables.image;
  if (!has_time(image)) return;
  is_timed_ = true;
  u32 clocks = 0;
  for (const Atom& atom : image.atoms) {
    clock_base_.push_back(clocks);
    const AtomTime* time = image.atom_types[atom.type].time;
    if (time == nullptr) continue;
    clocks += time->clocks.size;
    for (const Clock& clock : time->clocks) {
      if (unit_ == 0 || clock.unit < unit_) unit_ = clock.unit;
    }
  }
  clock_base_.push_back(clocks);
  if (unit_ == 0) unit_ = 1'000'000'000;
  core_.events.link();
  core_.actions.link();
  for (const AtomType& type : image.atom_types) types_.push_back(time_of_type(type, image));
  for (const ConnectorType& type : image.connector_types) has_sync_ |= type.resume_sync;
  has_open_eager_ = may_open_eagerly(image);
  find_ports_that_begin();
}

// A port for events takes one; of a port with two transitions both may be enabled, which is a fault.
void Clocks::find_ports_that_begin() {
  needs_begin_.assign(core_.tables.port_atom.size(), 0);
  for (u32 atom = 0; atom < core_.atoms.size; ++atom) {
    const AtomType& type = core_.tables.atom_type(atom);
    if (type.time == nullptr) continue;
    for (u32 port = 0; port < type.ports.size; ++port) {
      const auto labelled = std::count_if(type.transitions.begin(), type.transitions.end(),
                                          [&](const Transition& transition) { return transition.port == port; });
      needs_begin_[core_.tables.instance(atom, port)] = labelled > 1 || core_.events.is_event_port(atom, port) ? 1 : 0;
    }
  }
}

void Clocks::reset() {
  BIP_ASSERT(is_timed_ && clock_base_.size() == core_.atoms.size + std::size_t{1}, "{} atoms have clocks",
             clock_base_.size());
  now_ = 0;
  resumes_drawn_ = 0;
  clocks_.assign(clock_base_.back(), {});
  busy_until_.assign(core_.atoms.size, 0);
  may_resume_until_.assign(core_.atoms.size, kForever);
  ports_.assign(core_.ports.size(), {});
  coming_.assign(core_.atoms.size, {});
  core_.events.reset();
  set_clocks_.clear();
  resuming_.clear();
  core_.actions.reset();
  changes_.reset(core_.atoms.size);
  ends_.reset(core_.atoms.size);
}

std::size_t Clocks::bytes() const {
  return clock_base_.size() * sizeof(u32) + clocks_.size() * sizeof(ClockState) +
         (busy_until_.size() + may_resume_until_.size()) * sizeof(i64) +
         ports_.size() * (sizeof(PortTime) + sizeof needs_begin_[0]) + coming_.size() * sizeof(Coming) +
         changes_.bytes() + ends_.bytes();
}

// In 2^-32 ticks.
Int128 Clocks::exact_value(u32 atom, u32 clock) const {
  const ClockState& state = clocks_[clock_base_[atom] + clock];
  BIP_ASSERT(state.since <= now_ && clock < clock_base_[atom + 1] - clock_base_[atom],
             "clock {} of atom {} was set at {}", clock, atom, state.since);
  return (static_cast<Int128>(state.value) << 32) + state.fraction +
         static_cast<Int128>(state.speed) * (now_ - state.since);
}

void Clocks::start_clocks(u32 atom) {
  const AtomTime* time = core_.tables.atom_type(atom).time;
  if (time == nullptr) return;
  Cell* self = core_.memory.cells.from(core_.atoms[atom].first_cell);
  for (const Clock& clock : time->clocks) self[clock.variable + 2].f = 1.0;
}

void Clocks::show_clocks(u32 atom) {
  if (!types_[core_.atoms[atom].type].has_reads) return;
  const AtomTime* time = types_[core_.atoms[atom].type].time;
  Cell* self = core_.memory.cells.from(core_.atoms[atom].first_cell);
  for (u32 row = 0; row < time->clocks.size; ++row) {
    const Clock& clock = time->clocks[row];
    if (clock.is_read)
      self[clock.variable].f = static_cast<double>(clock_value(atom, row)) / static_cast<double>(clock.unit);
  }
}

// Takes what an action said of the clocks out of the hidden variables.
bool Clocks::read_clocks(u32 atom, const Transition* fired) {
  const AtomTime* time = types_[core_.atoms[atom].type].time;
  if (time == nullptr) return true;
  Cell* self = core_.memory.cells.from(core_.atoms[atom].first_cell);
  ClockState* states = clocks_.data() + clock_base_[atom];
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
      state = {static_cast<i64>(value), now_, std::llround(speed * static_cast<double>(kUnitSpeed)), 0};
      self[clock.variable + 2].f = static_cast<double>(state.speed) / static_cast<double>(kUnitSpeed);
    }
    if (self[clock.variable + 1].i == 0) {
      // What the action read belongs to no state.
      if (clock.is_read) self[clock.variable] = Cell{0};
      continue;
    }
    const double value = self[clock.variable].f;
    self[clock.variable] = self[clock.variable + 1] = Cell{0};
    set_clocks_.push_back(clock_base_[atom] + row);
    if (!to_ticks(value, clock.unit, state.value)) return fail_clock(atom, clock, fired, "value", value);
    BIP_ASSERT(state.value <= kMaxTicks && state.value >= -kMaxTicks, "clock {} at {}", row, state.value);
    BIP_ASSERT(state.speed >= 0 && state.speed <= kMaxSpeed, "clock {} at speed {}", row, state.speed);
    state.since = now_;
    state.fraction = 0;
  }
  return true;
}

// The limits that are no constants, into their hidden variables.
bool Clocks::measure_limits(u32 atom, const TimeGuard& when) {
  const Code measure = core_.tables.code(when.measure);
  if (measure.fn == nullptr) return true;
  const std::int32_t status = measure.fn(measure.context, core_.memory.cells.from(core_.atoms[atom].first_cell),
                                         core_.memory.cells.all(), nullptr);
  return status < 2 || core_.faults.fail_code(status, atom, kNone, nullptr, "a limit of a clock");
}

// Takes a measured limit out of its variable. False: it is no number, and compares with nothing.
bool Clocks::take_limit(u32 atom, const Bound& bound, i64& limit) {
  limit = bound.ticks;
  if (bound.variable == kNone) return true;
  Cell* self = core_.memory.cells.from(core_.atoms[atom].first_cell);
  const double value = self[bound.variable].f;
  self[bound.variable] = Cell{0};
  // What is beyond all clocks is still above or below them.
  if (!to_ticks(value, types_[core_.atoms[atom].type].time->clocks[bound.clock].unit, limit))
    limit = value > 0 ? kMaxTicks : -kMaxTicks;
  return !std::isnan(value);
}

// The instants from now on at which all bounds hold.
bool Clocks::interval_of(u32 atom, const TimeGuard& when, Interval& out) {
  const i64 now = now_;
  out = {now, kForever, false, false};
  if (when.bounds.size == 0) return true;
  if (when.measure != kNone && !measure_limits(atom, when)) return false;
  const ClockState* states = clocks_.data() + clock_base_[atom];
  BIP_ASSERT(std::all_of(when.bounds.begin(), when.bounds.end(),
                         [&](const Bound& bound) { return bound.clock < clock_base_[atom + 1] - clock_base_[atom]; }),
             "a bound on a clock that atom {} does not have", atom);
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
    Int128 exact = exact_value(atom, bound.clock);
    i64 speed = clock.speed;
    if (bound.minus != kNone) {
      exact -= exact_value(atom, bound.minus);
      speed -= states[bound.minus].speed;
    }
    out.meet(instants_of(now, exact, speed, bound.op, limit));
  }
  return true;
}

bool Clocks::resume_interval(u32 atom, const Resume& resume, Interval& out) {
  if (!interval_of(atom, resume.when, out)) return false;
  const Code guard = core_.tables.code(resume.guard);
  if (guard.fn == nullptr) return true;
  const std::int32_t status =
      guard.fn(guard.context, core_.memory.cells.from(core_.atoms[atom].first_cell), core_.memory.cells.all(), nullptr);
  if (status >= 2) return core_.faults.fail_code(status, atom, kNone, nullptr, "what `resume` waits for");
  if (status == 0) out = Interval::none();
  return true;
}

// After a step of the atom, internal transitions included: how long is it busy? fired: null for `initial`.
bool Clocks::begin_resume(u32 atom, const LinkedTransition* fired) {
  busy_until_[atom] = 0;
  may_resume_until_[atom] = kForever;
  const TypeTime& type = types_[core_.atoms[atom].type];
  if (!type.has_resume) return true;
  const AtomTime* time = type.time;
  const u32 first = core_.tables.types[core_.atoms[atom].type].first_transition;
  const Resume& resume =
      fired == nullptr ? time->initial
                       : time->transitions[static_cast<u32>(fired - core_.tables.transitions.data()) - first].resume;
  if (!resume.present) return true;
  Interval interval;
  if (!resume_interval(atom, resume, interval)) return false;
  const bool is_drawn = draws_resumes_ && !resumes_together_ && !interval.empty();
  busy_until_[atom] = waits_for_resume_at_ || interval.empty() ? kForever
                      : is_drawn                               ? draw_resume(interval.low, interval.high)
                                                               : interval.low;
  may_resume_until_[atom] = interval.high;
  resuming_.push_back(atom);
  BIP_ASSERT(busy_until_[atom] >= now_, "atom {} was busy until {}", atom, busy_until_[atom]);
  return true;
}

void Clocks::draw_resumes(u64 seed) {
  draws_resumes_ = std::any_of(types_.begin(), types_.end(), [](const TypeTime& type) { return type.has_resume; });
  resume_seed_ = seed;
  resumes_drawn_ = 0;
}

// Each draw has a generator of its own: what the state has to keep is a number.
i64 Clocks::draw_resume(i64 first, i64 last) {
  if (first == last) return first;
  constexpr u64 kOdd = 0x9fb21c651e98df25u;
  Prng prng(~resume_seed_ ^ ++resumes_drawn_ * kOdd);
  return draw_instant(prng, first, last, unit_);
}

bool Clocks::has_initial_resume() const {
  return std::any_of(types_.begin(), types_.end(),
                     [](const TypeTime& type) { return type.time != nullptr && type.time->initial.present; });
}

// The ports of one interaction go on together, at an instant at which all may; without one, never.
bool Clocks::resume_together(std::vector<u32>& rows) {
  i64 until = 0, last = kForever;
  // Who is at work goes on by itself.
  rows.erase(std::remove_if(rows.begin(), rows.end(), [this](u32 atom) { return core_.actions.is_at_work(atom); }),
             rows.end());
  for (const u32 atom : rows) {
    until = std::max(until, busy_until_[atom]);
    last = std::min(last, may_resume_until_[atom]);
  }
  if (until > last) until = kForever;
  const auto is_listed = [this](u32 atom) {
    return std::find(resuming_.begin(), resuming_.end(), atom) != resuming_.end();
  };
  if (std::none_of(rows.begin(), rows.end(), is_listed)) return true;
  if (draws_resumes_ && until < last) until = draw_resume(until, last);
  for (const u32 atom : rows) {
    // Who has no `resume` itself goes on with the others.
    if (!is_listed(atom)) resuming_.push_back(atom);
    may_resume_until_[atom] = last;
    if (busy_until_[atom] == until) continue;
    busy_until_[atom] = until;
    if (!look_at_time(atom)) return false;
  }
  return true;
}

bool Clocks::resume_at(u32 atom, i64 instant) {
  BIP_ASSERT(instant >= now_, "atom {} goes on at {}, before {}", atom, instant, now_);
  if (busy_until_[atom] == instant) return true;
  busy_until_[atom] = instant;
  return look_at_time(atom) && core_.settle();
}

bool Clocks::returned_at(i64 instant) {
  BIP_ASSERT(instant >= now_, "actions returned at {}, before {}", instant, now_);
  for (const u32 atom : resuming_) {
    const i64 until = std::max(busy_until_[atom], std::min(instant, may_resume_until_[atom]));
    if (busy_until_[atom] == until) continue;
    busy_until_[atom] = until;
    if (!look_at_time(atom)) return false;
  }
  return core_.settle();
}

bool Clocks::is_resumed(const Candidate& candidate) {
  core_.firing.participants(candidate, participant_scratch_);
  return std::all_of(participant_scratch_.begin(), participant_scratch_.end(), [this](const Participant& p) {
    const u32 type = core_.atoms[p.atom].type;
    if (types_[type].time == nullptr) return true;
    const u32 transition = core_.ports.port(core_.tables.instance(p.atom, p.port)).transition;
    return transition != kNone &&
           types_[type].time->transitions[transition - core_.tables.types[type].first_transition].resume.present;
  });
}

Fault Clocks::late_resume(u32 atom, i64 actual) const {
  Fault fault;
  fault.code = FaultCode::LateStep;
  fault.atom = atom;
  fault.loc = core_.image().atoms[atom].loc;
  fault.what = "component `" + core_.image().atoms[atom].path() + "` may resume until ";
  append_time(fault.what, may_resume_until_[atom]);
  fault.what += ", and its action, begun at ";
  append_time(fault.what, now_);
  fault.what += ", returns at ";
  append_time(fault.what, actual);
  return fault;
}

bool Clocks::fail_late_resume(u32 atom, i64 actual) {
  core_.fault = late_resume(atom, actual);
  return false;
}

void Clocks::save(std::vector<i64>& out) const {
  out.push_back(now_);
  for (u32 atom = 0; atom < core_.atoms.size; ++atom) save_atom(atom, out);
  core_.actions.save(out);
  core_.events.save(out);
  if (draws_resumes_) out.push_back(static_cast<i64>(resumes_drawn_));
}

void Clocks::save_atom(u32 atom, std::vector<i64>& out) const {
  for (u32 clock = 0; clock < clock_base_[atom + 1] - clock_base_[atom]; ++clock) {
    out.push_back(static_cast<i64>(clock_value(atom, clock)));
    const i64 speed = out.emplace_back(clocks_[clock_base_[atom] + clock].speed);
    if (has_fraction(speed)) out.push_back(static_cast<i64>(exact_value(atom, clock) & (kUnitSpeed - 1)));
  }
  out.push_back(std::max(busy_until_[atom], now_));
}

bool Clocks::is_saved(u32 atom, const std::vector<i64>& words) const {
  std::size_t at = 0;
  for (u32 clock = clock_base_[atom]; clock < clock_base_[atom + 1]; ++clock) {
    if (at + 2 > words.size() || words[at + 1] < 0 || words[at + 1] > kMaxSpeed) return false;
    at += has_fraction(words[at + 1]) ? 3 : 2;
  }
  return at + 1 == words.size() && words[at] >= 0;
}

void Clocks::load(const std::vector<i64>& in) {
  set_clocks_.clear();
  resuming_.clear();
  const i64* next = in.data();
  now_ = *next++;
  BIP_ASSERT(now_ >= 0, "the instant {}", now_);
  for (u32 atom = 0; atom < core_.atoms.size; ++atom) {
    for (u32 clock = clock_base_[atom]; clock < clock_base_[atom + 1]; ++clock) {
      const i64 value = *next++, speed = *next++;
      BIP_ASSERT(speed >= 0 && speed <= kMaxSpeed, "clock {} at speed {}", clock, speed);
      clocks_[clock] = {value, now_, speed, has_fraction(speed) ? static_cast<u32>(*next++) : 0};
    }
    busy_until_[atom] = *next++;
  }
  next = core_.events.load(core_.actions.load(next));
  // A state of a run that draws, or of one that does not.
  const bool is_counted = next != in.data() + in.size();
  if (draws_resumes_ && is_counted) resumes_drawn_ = static_cast<u64>(*next);
  BIP_ASSERT(next + (is_counted ? 1 : 0) == in.data() + in.size(), "a state of {} words of another image", in.size());
}

// A timed atom's ports at this instant, into the scratch for ports, and what is next.
inline bool Clocks::find_ports(u32 atom, bool is_busy, i64& next, u32& possible) {
  const AtomInfo& state = core_.atoms[atom];
  const LinkedType& type = core_.tables.types[state.type];
  const TypeTime& rules = types_[state.type];
  const AtomTime& time = *rules.time;
  const u32 ports = core_.tables.port_base(atom + 1) - state.port_base;
  u32* now = core_.atom_steps.port_scratch();
  for (u32 port = 0; port < ports; ++port) now[port] = kNone;
  next = is_busy ? busy_until_[atom] : kForever;
  possible = 0;
  Coming& coming = coming_[atom];
  coming.transition = kNone;
  const bool is_automaton = type.mark_words == 0;
  // Of automata those that leave the place, of others all.
  const Span<u32> leaving = is_automaton ? core_.tables.place_transitions[type.first_place + core_.memory.places[atom]]
                                         : Span<u32>{nullptr, type.transition_count};
  for (u32 k = 0; k < leaving.size && !is_busy; ++k) {
    const u32 row = is_automaton ? leaving[k] : type.first_transition + k;
    const LinkedTransition& transition = core_.tables.transitions[row];
    if (!is_automaton && transition.port == kNone) continue;
    const TransitionTime& timing = time.transitions[row - type.first_transition];
    bool is_enabled = true;
    if ((!is_automaton || transition.guard.fn != nullptr) &&
        !core_.atom_steps.is_enabled_from(atom, transition, is_enabled))
      return false;
    if (!is_enabled || core_.events.is_without_event(state.port_base + transition.port)) continue;
    Interval interval;
    if (!interval_of(atom, timing.when, interval)) return false;
    if (interval.empty()) continue;
    BIP_ASSERT(interval.high >= now_ && interval.low >= now_, "transition {} was possible until {}", row,
               interval.high);
    ++possible;
    if (interval.low > now_) {
      // Time may have to stop at an open bound itself.
      const bool is_bound_ahead = has_open_eager_ && interval.low_open && interval.low - 1 > now_;
      next = std::min(next, is_bound_ahead ? interval.low - 1 : interval.low);
      coming = {row, timing.urgency, interval};
      continue;
    }
    if (interval.high != kForever) next = std::min(next, interval.high + 1);
    PortTime& port = ports_[state.port_base + transition.port];
    if (now[transition.port] != kNone) {
      port.other = row;
      port.interval.meet(interval);
      port.urgency = std::max(port.urgency, timing.urgency);
      continue;
    }
    now[transition.port] = row;
    port = {interval, timing.urgency, kNone};
  }
  if (time.events.size != 0 && !core_.events.refuse(atom, now)) return false;
  if (type.has_priorities && !core_.atom_priorities.hide_ports(atom, now)) return false;
  BIP_ASSERT(next > now_, "ports of atom {} change at {}", atom, next);
  changes_.set(atom, next);
  return true;
}

bool Clocks::look_at_time(u32 atom) {
  BIP_ASSERT(core_.tables.atom_type(atom).time != nullptr, "atom {} has nothing to do with time", atom);
  const bool is_busy = busy_until_[atom] > now_;
  if (!is_busy && core_.actions.is_at_work(atom)) return core_.actions.finish_action(atom);
  i64 next = 0;
  u32 possible = 0;
  if (!find_ports(atom, is_busy, next, possible)) return false;
  const u32 first = core_.atoms[atom].port_base, ports = core_.tables.port_base(atom + 1) - first;
  const u32* now = core_.atom_steps.port_scratch();
  for (u32 port = 0; port < ports; ++port) core_.ports.set_port(first + port, now[port]);
  const TypeTime& rules = types_[core_.atoms[atom].type];
  Coming& coming = coming_[atom];
  if (possible != 1 || !rules.is_foreseeable) coming.transition = kNone;
  return !rules.has_limits || look_at_invariants(atom);
}

bool Clocks::find_ports(u32 atom) {
  const bool is_busy = busy_until_[atom] > now_;
  BIP_ASSERT(is_busy || !core_.actions.is_at_work(atom), "the action of atom {} ends", atom);
  i64 next = 0;
  u32 possible = 0;
  if (!find_ports(atom, is_busy, next, possible)) return false;
  coming_[atom].transition = kNone;
  return !types_[core_.atoms[atom].type].has_limits || look_at_invariants(atom);
}

void Clocks::forget(u32 atom) {
  coming_[atom].transition = kNone;
  changes_.set(atom, kForever);
  ends_.set(atom, kForever);
}

void Clocks::pass_to(i64 to, std::vector<u32>& changed) {
  BIP_ASSERT(to >= now_, "from {} back to {}", now_, to);
  now_ = to;
  while (changes_.first_key() <= to) {
    changed.push_back(changes_.first_row());
    forget(changed.back());
  }
}

// What a look would find: the interval of the one transition that was waited for has begun, all else is as it was,
// invariants included.
inline void Clocks::enable_coming(u32 atom) {
  Coming& coming = coming_[atom];
  BIP_ASSERT(coming.transition != kNone && coming.interval.has(now_), "transition {} is possible from {} on",
             coming.transition, coming.interval.low);
  const u32 instance = core_.atoms[atom].port_base + core_.tables.transitions[coming.transition].port;
  ports_[instance] = {coming.interval, coming.urgency, kNone};
  changes_.set(atom, coming.interval.high == kForever ? kForever : coming.interval.high + 1);
  core_.ports.set_port(instance, coming.transition);
  coming.transition = kNone;
}

// The last instant that the invariants of the atom's places allow: no time passes where one does not hold.
bool Clocks::look_at_invariants(u32 atom) {
  const AtomType& type = core_.tables.atom_type(atom);
  i64 end = kForever;
  // What bounds the time at work is the budget.
  for (u32 row = core_.actions.is_at_work(atom) ? type.invariants.size : 0; row < type.invariants.size; ++row) {
    if (type.time->invariants[row].bounds.size == 0 || !core_.atom_steps.is_in_scope(atom, type.invariants[row]))
      continue;
    Interval interval;
    if (!interval_of(atom, type.time->invariants[row], interval)) return false;
    end = std::min(end, interval.has(now_) ? interval.high : now_);
  }
  BIP_ASSERT(end >= now_, "the invariants of atom {} ended at {}", atom, end);
  ends_.set(atom, end);
  return true;
}

bool Clocks::advance(i64 to) {
  BIP_ASSERT(to >= now_ && to <= std::max(next_change(), now_), "from {} to {}, and ports change at {}", now_, to,
             next_change());
  now_ = to;
  while (changes_.first_key() <= to) {
    const u32 atom = changes_.first_row();
    if (coming_[atom].transition != kNone && coming_[atom].interval.low == to) enable_coming(atom);
    else if (!look_at_time(atom)) return false;
  }
  BIP_ASSERT(is_consistent(), "after the instant {}", now_);
  return core_.settle();
}

CandidateTime Clocks::time_of(const Candidate& candidate) {
  CandidateTime out{{now_, kForever, false, false}, Urgency::Lazy};
  // Ports of other atoms have no limits.
  const auto meet = [&](u32 instance) {
    const PortTime& port = ports_[instance];
    out.interval.meet(port.interval);
    out.urgency = std::max(out.urgency, port.urgency);
    BIP_ASSERT(port.interval.has(now_), "a candidate's port was possible until {}", port.interval.high);
  };
  const InteractionInfo info = core_.tables.interactions[candidate.interaction];
  if (info.kind == InteractionKind::Port) {
    meet(info.row);
  } else {
    for (const u32 instance : core_.firing.ports(candidate)) meet(instance);
  }
  return out;
}

bool Clocks::begin_port(u32 instance) {
  const PortState& port = core_.ports.port(instance);
  if (const u32 other = ports_[instance].other; other != kNone) {
    return core_.faults.fail(FaultCode::TwoTransitions, core_.tables.port_atom[instance],
                             core_.tables.transitions[port.transition].source, core_.tables.transitions[other].source);
  }
  if (!core_.events.empty()) core_.events.take(instance);
  return true;
}

bool Clocks::take(EnabledSet::Position at) {
  BIP_ASSERT(is_timed_ && core_.enabled.has(at), "no candidate {} of interaction {}", at.rank, at.interaction);
  set_clocks_.clear();
  resuming_.clear();
  const InteractionInfo info = core_.tables.interactions[at.interaction];
  const bool is_sync =
      has_sync_ && info.kind != InteractionKind::Port && core_.tables.connector_type(info.row).resume_sync;
  if (info.kind == InteractionKind::Port) return begin_port(info.row) && core_.firing.take(at);
  const Span<u32> ports = core_.tables.fixed_ports(info);
  if (ports.size != 0 && !is_sync) {
    bool is_timed = false;
    for (const u32 instance : ports) {
      if (needs_begin_[instance] != 0 && !begin_port(instance)) return false;
      is_timed = is_timed || core_.ports.port(instance).place == kNone;
    }
    // Where places do not say all there is no program: not asked for again.
    if (!is_timed || info.kind != InteractionKind::Flat) return core_.firing.take(at);
    core_.history.remember(at.interaction);
    return core_.firing.fire_flat(info) && core_.settle();
  }
  const Candidate chosen = core_.candidate(at);
  const Span<u32> taking_part = core_.firing.ports(chosen);
  std::vector<u32> together;
  for (const u32 instance : taking_part) {
    const u32 atom = is_sync ? core_.tables.port_atom[instance] : kNone;
    if (is_sync && types_[core_.atoms[atom].type].time != nullptr) together.push_back(atom);
    if (needs_begin_[instance] != 0 && !begin_port(instance)) return false;
  }
  resumes_together_ = together.size() >= 2;
  const bool is_fired = core_.firing.fire(chosen, taking_part);
  resumes_together_ = false;
  if (!is_fired) return false;
  if (together.size() < 2) return true;
  if (!resume_together(together)) return false;
  return core_.settle();
}

// An eager candidate lets no time pass, a delayable one none beyond its last instant.
i64 Clocks::wait_limit(std::vector<i64>& ends) {
  i64 last = last_instant();
  ends.clear();
  for (u64 k = 0; k < core_.enabled.total(); ++k) {
    const CandidateTime time = time_of(core_.candidate(core_.enabled.select(k)));
    ends.push_back(time.interval.high);
    if (time.urgency == Urgency::Eager) last = now();
    else if (time.urgency == Urgency::Delayable) last = std::min(last, time.interval.high);
  }
  BIP_ASSERT(ends.size() == core_.enabled.total(), "{} of {} candidates", ends.size(), core_.enabled.total());
  if (last > now() && is_before_eager()) return now();
  return std::max(last, now());
}

u64 Clocks::opened_eager() {
  const u64 count = core_.enabled.total();
  for (u64 k = 0; k < count; ++k) {
    const CandidateTime time = time_of(core_.candidate(core_.enabled.select(k)));
    if (time.urgency == Urgency::Eager && time.interval.low == now_ && time.interval.low_open) return k;
  }
  return count;
}

bool Clocks::advance_while_busy() {
  for (u32 atom = 0; atom < busy_until_.size(); ++atom)
    if (busy_until_[atom] == now_ + 1 && !resume_at(atom, kForever)) return false;
  return advance(now_ + 1);
}

bool Clocks::is_before_eager() {
  if (!has_open_eager_ || next_change() != now_ + 1) return false;
  const State before = core_.snapshot();
  const std::vector<InteractionId> order = core_.enabled.list_order();
  const bool is_before = advance_while_busy() && opened_eager() != core_.enabled.total();
  [[maybe_unused]] const bool is_back = core_.restore(before);
  BIP_ASSERT(is_back, "a state that was reached cannot be restored");
  if (core_.keeps_list) core_.enabled.list(order, static_cast<u32>(core_.tables.interactions.size()));
  return is_before;
}

bool Clocks::fail_clock(u32 atom, const Clock& clock, const Transition* fired, const char* what, double value) {
  core_.fault = {};
  core_.fault.code = FaultCode::BadClock;
  core_.fault.atom = atom;
  core_.fault.loc = fired != nullptr ? fired->loc : clock.loc;
  core_.fault.places = places_of(core_, atom);
  core_.fault.data = data_of(core_, atom);
  core_.fault.what =
      std::string("clock `") + clock.name + "` of `" + core_.image().atoms[atom].path() + "` gets the " + what + " ";
  append_double(core_.fault.what, value);
  core_.fault.what += " at ";
  append_time(core_.fault.what, now());
  return false;
}

Fault Clocks::late_step(const Candidate& candidate, i64 last, i64 actual) const {
  Fault fault;
  fault.code = FaultCode::LateStep;
  fault.connector = candidate.connector;
  fault.atom = candidate.atom;
  if (candidate.connector != kNone) {
    fault.loc = core_.image().connectors[candidate.connector].loc;
    fault.what = "connector `" + core_.image().connectors[candidate.connector].path();
  } else {
    fault.loc = core_.tables.atom_type(candidate.atom).ports[candidate.port].loc;
    fault.what = "port `" + core_.image().atoms[candidate.atom].path() + '.' +
                 core_.tables.atom_type(candidate.atom).ports[candidate.port].name;
  }
  fault.what += "`, planned for ";
  append_time(fault.what, now());
  fault.what += " and possible until ";
  append_time(fault.what, last);
  fault.what += ", starts at ";
  append_time(fault.what, actual);
  return fault;
}

bool Clocks::fail_late(const Candidate& candidate, i64 last, i64 actual) {
  core_.fault = late_step(candidate, last, actual);
  return false;
}

// Names the atom whose port would be eager from the next tick on.
void Clocks::describe_open_bound() {
  const i64 end = now_;
  const State before = core_.snapshot();
  if (!advance_while_busy()) return;
  core_.firing.participants(core_.candidate(core_.enabled.select(opened_eager())), participant_scratch_);
  Participant eager = participant_scratch_.front();
  for (const Participant& participant : participant_scratch_) {
    const PortTime& port = ports_[core_.tables.instance(participant.atom, participant.port)];
    if (port.interval.low == now_ && port.interval.low_open) eager = participant;
  }
  const LinkedTransition& transition =
      core_.tables.transitions[core_.ports.port(core_.tables.instance(eager.atom, eager.port)).transition];
  if (!core_.restore(before)) return;
  core_.fault = {};
  core_.fault.code = FaultCode::TimeLock;
  core_.fault.atom = eager.atom;
  core_.fault.loc = transition.source->loc;
  core_.fault.places = places_of(core_, eager.atom);
  core_.fault.data = data_of(core_, eager.atom);
  core_.fault.what = "time lock at ";
  append_time(core_.fault.what, end);
  core_.fault.what +=
      std::string(": no step is possible, and an eager one is at every later instant, because of an open bound of `") +
      core_.image().atoms[eager.atom].path() + '.' + core_.tables.atom_type(eager.atom).ports[eager.port].name + '`';
}

// No step, and no time either.
bool Clocks::fail_time_lock() {
  if (last_instant() > now_ && is_before_eager()) {
    describe_open_bound();
    return false;
  }
  const u32 atom = ends_.first_row();
  const i64 end = std::max(ends_.first_key(), now_);
  BIP_ASSERT(core_.enabled.total() == 0, "{} steps are possible", core_.enabled.total());
  now_ = end;
  core_.fault = {};
  core_.fault.code = FaultCode::TimeLock;
  core_.fault.atom = atom;
  core_.fault.places = places_of(core_, atom);
  core_.fault.data = data_of(core_, atom);
  core_.fault.what = "time lock at ";
  append_time(core_.fault.what, end);
  core_.fault.what += ": no step is possible, and ";
  const AtomType& type = core_.tables.atom_type(atom);
  for (u32 row = 0; row < type.invariants.size; ++row) {
    if (type.time->invariants[row].bounds.size == 0 || !core_.atom_steps.is_in_scope(atom, type.invariants[row]))
      continue;
    Interval interval;
    if (!interval_of(atom, type.time->invariants[row], interval)) return false;
    if (interval.has(now()) && interval.high != end) continue;
    if (!core_.fault.rule.empty()) continue;
    core_.fault.rule = type.invariants[row].name;
    core_.fault.loc = type.invariants[row].loc;
  }
  core_.fault.what += "invariant `" + core_.fault.rule + "` of `" + core_.image().atoms[atom].path() + "` at `" +
                      core_.fault.places + "` lets no time pass";
  return false;
}

}  // namespace bip::rt
