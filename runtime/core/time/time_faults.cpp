// Run-time errors of time, and times as text.
#include "runtime/core/core.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

void append_time(std::string& out, i64 ticks) {
  if (ticks < 0) {
    out += '-';
    ticks = -ticks;
  }
  if (ticks == 0) out += '0';
  constexpr std::pair<i64, const char*> kUnits[] = {{1'000'000'000, "s"}, {1'000'000, "ms"}, {1'000, "us"}, {1, "ns"}};
  for (const auto& [length, name] : kUnits) {
    if (ticks < length) continue;
    append_number(out, static_cast<u64>(ticks / length));
    out += name;
    ticks %= length;
  }
}

void append_interval(std::string& out, const Interval& interval) {
  out += interval.low_open ? "] " : "[ ";
  append_time(out, interval.low - (interval.low_open ? 1 : 0));
  out += ", ";
  if (interval.high == kForever) {
    out += "+INFTY [";
    return;
  }
  append_time(out, interval.high + (interval.high_open ? 1 : 0));
  out += interval.high_open ? " [" : " ]";
}

bool Core::fail_clock(u32 atom, const Clock& clock, const Transition* fired, const char* what, double value) {
  fault_ = {};
  fault_.code = FaultCode::BadClock;
  fault_.atom = atom;
  fault_.loc = fired != nullptr ? fired->loc : clock.loc;
  fault_.places = places_of(*this, atom);
  fault_.data = data_of(*this, atom);
  fault_.what =
      std::string("clock `") + clock.name + "` of `" + image().atoms[atom].path() + "` gets the " + what + " ";
  append_double(fault_.what, value);
  fault_.what += " at ";
  append_time(fault_.what, now());
  return false;
}

bool Core::fail_late(const Candidate& candidate, i64 last, i64 actual) {
  fault_ = {};
  fault_.code = FaultCode::LateStep;
  fault_.connector = candidate.connector;
  fault_.atom = candidate.atom;
  if (candidate.connector != kNone) {
    fault_.loc = image().connectors[candidate.connector].loc;
    fault_.what = "connector `" + image().connectors[candidate.connector].path();
  } else {
    fault_.loc = tables_.atom_type(candidate.atom).ports[candidate.port].loc;
    fault_.what = "port `" + image().atoms[candidate.atom].path() + '.' +
                  tables_.atom_type(candidate.atom).ports[candidate.port].name;
  }
  fault_.what += "`, planned for ";
  append_time(fault_.what, now());
  fault_.what += " and possible until ";
  append_time(fault_.what, last);
  fault_.what += ", starts at ";
  append_time(fault_.what, actual);
  return false;
}

// No step, and no time either.
bool Core::fail_time_lock() {
  const u32 atom = time_->ends.first_row();
  const i64 end = std::max(time_->ends.first_key(), time_->now);
  time_->now = end;
  fault_ = {};
  fault_.code = FaultCode::TimeLock;
  fault_.atom = atom;
  fault_.places = places_of(*this, atom);
  fault_.data = data_of(*this, atom);
  fault_.what = "time lock at ";
  append_time(fault_.what, end);
  fault_.what += ": no step is possible, and ";
  const AtomType& type = tables_.atom_type(atom);
  for (u32 row = 0; row < type.invariants.size; ++row) {
    if (type.time->invariants[row].bounds.size == 0 || !is_in_scope(atom, type.invariants[row])) continue;
    Interval interval;
    if (!interval_of(atom, type.time->invariants[row], interval)) return false;
    if (interval.has(now()) && interval.high != end) continue;
    if (!fault_.rule.empty()) continue;
    fault_.rule = type.invariants[row].name;
    fault_.loc = type.invariants[row].loc;
  }
  fault_.what += "invariant `" + fault_.rule + "` of `" + image().atoms[atom].path() + "` at `" + fault_.places +
                 "` lets no time pass";
  return false;
}

}  // namespace bip::rt
