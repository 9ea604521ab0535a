// What a core keeps about time: the instant, each clock's value, who is busy, and what happens next by itself.
//
// Present only in cores of images with time. `changes` and `ends` are functions of the rest; they are brought up to
// date when an atom is looked at, so that the cost of a step is that of the atoms that moved, times O(log atoms).
#pragma once
#include "runtime/core/link/tables.hpp"
#include "runtime/core/time/time_heap.hpp"

namespace bip::rt {

struct ClockState {
  i64 value = 0;  // at `since`
  i64 since = 0;
  i64 speed = kUnitSpeed;  // in 2^-32
};
/// Of a port that is enabled now.
struct PortTime {
  Interval interval{};  // of its transition, around now
  Urgency urgency = Urgency::Lazy;
  u32 other = kNone;  // a second enabled transition: to fire the port is a fault
};

/// What is known of a type of atoms before the first step.
struct TypeTime {
  const AtomTime* time = nullptr;  // null: it has nothing to do with time
  bool has_resume = false;
  bool has_limits = false;  // invariants that bound clocks
  bool is_foreseeable =
      false;  // while clocks run at speed 1 what an atom offers later follows from what it was when it last moved
};
/// The next change of an atom's ports, if it is no more than that one port, the only one then, becomes enabled.
struct Coming {
  u32 transition = kNone;  // row of Tables::transitions; kNone: it is something else
  Urgency urgency = Urgency::Lazy;
  Interval interval{};
};

/// A step that may be taken now: around now the instants at which it may be, and how long time may wait for it.
struct CandidateTime {
  Interval interval{};
  Urgency urgency = Urgency::Lazy;
};

/// A port for events of one atom (events.cpp).
struct EventPortRow {
  u32 atom = 0, port = 0;
  u32 width = 0;  // values an event carries
  EventPolicy policy = EventPolicy::Remember;
  u32 source = kNone;  // row of Image::event_classes
};
/// Events that came and were not taken, first come first taken. A part of the state.
struct EventQueue {
  u32 count = 0;
  u32 first = 0;  // row of `values` of the first one
  std::vector<Cell> values;
};

/// A condition on an atom's clocks as its data are now: each clock (minus another) from low to high, in ticks.
inline constexpr i64 kNoBound = INT64_MAX;      // of high; -kNoBound of low
inline constexpr i64 kFarLimit = i64{1} << 59;  // beyond it a limit counts as infinite: 18 years
struct ClockBound {
  u32 clock, minus;  // of the atom's type; minus: kNone: 0
  i64 low = -kNoBound, high = kNoBound;
};
struct MeasuredGuard {
  bool can_hold = true;  // false: whatever the clocks are
  std::vector<ClockBound> bounds;
};
/// A transition that the atom's marking and data enable, at whatever instant.
struct TimedTransition {
  u32 row = kNone, port = kNone;  // of the type
  Urgency urgency = Urgency::Lazy;
  MeasuredGuard when;
};

/// An atom whose action runs beside the others (async.cpp).
struct AtWork {
  u32 transition = kNone;   // row of Tables::transitions; kNone: it is not
  u32 place = kNone;        // where it was before
  i64 until = kForever;     // the end of the budget
  u64 job = 0;              // of the pool; 0: none
  bool is_overrun = false;  // nothing is to be said of the budget any more
};

class ActionPool;
struct TimeState {
  i64 now = 0;
  std::vector<u32> clock_base;  // by atom, and the total
  std::vector<ClockState> clocks;
  std::vector<i64> busy_until;        // by atom; > now: no port is enabled before then
  std::vector<i64> may_resume_until;  // by atom: the last instant of what its `resume` waited for
  std::vector<TypeTime> types;        // by type of atoms
  bool has_sync = false;              // of some connector the ports resume together
  std::vector<PortTime> ports;        // by port instance
  std::vector<Coming> coming;         // by atom, at the instant that `changes` says
  std::vector<EventPortRow> event_ports;
  std::vector<u32> event_row;      // by port instance: row of event_ports, or kNone; empty if there are none
  std::vector<EventQueue> queues;  // by row of event_ports
  std::vector<u32> set_clocks;     // rows of `clocks` that were set since the last restore or timed step began
  TimeHeap changes;                // by atom: the next instant at which its ports may change
  TimeHeap ends;                   // by atom: the last instant that its invariants allow
  std::vector<AtWork> at_work;     // by atom; empty: no type has such actions
  std::vector<u32> working;        // those at work, in the order in which they began
  bool waits_for_returns = false;  // real time, replay: somebody says when an action returns
  ActionPool* pool = nullptr;      // where actions run; null: where they return
  i64 unit = 0;                    // the shortest of all clocks; a second without clocks
};

/// `4ms200us939ns`, `6s`, `0`.
void append_time(std::string& out, i64 ticks);
/// `[ 0, 5ms ]`, `] 2s, +INFTY [`.
void append_interval(std::string& out, const Interval& interval);

}  // namespace bip::rt
