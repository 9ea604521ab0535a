// Time in the core: clocks, conditions on them as intervals of instants, invariants that bound the time spent,
// `resume`, and what timed atoms offer at an instant.
//
// What is enabled is still a matter of one instant. A timed atom's ports are found for `now`, and with them the next
// instant at which they may change and the last one that its invariants allow; `advance` goes to an instant and looks
// at those atoms again whose ports may have changed. Everything between atoms (connectors, priorities, maximal
// progress) is as without time, so a dominated interaction is hidden at exactly those instants at which a dominating
// one is enabled.
//
// An atom is looked at when it has moved and when its ports may change by themselves. A periodic atom's only change is
// that the port it waits for becomes enabled: a look foresees that, interval and all, so that to let time pass
// evaluates nothing. Cost of a step: one look at each atom that took part, O(log atoms) for each instant that is kept.
// A core of an image without time has one of these, empty.
#pragma once
#include <vector>

#include "runtime/core/fire/fault.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/core/state/enabled_set.hpp"
#include "runtime/core/state/state.hpp"
#include "runtime/core/time/interval.hpp"
#include "runtime/core/time/open_eager.hpp"
#include "runtime/core/time/time_heap.hpp"

namespace bip::rt {

struct CoreParts;

/// Has a transition of the type, or its `initial`, a `resume`?
[[nodiscard]] bool has_resume(const AtomTime& time);
/// Has an atom to do with time?
[[nodiscard]] bool has_time(const Image& image);
struct ClockState {
  i64 value = 0;  // at `since`
  i64 since = 0;
  i64 speed = kUnitSpeed;      // in 2^-32
  std::uint32_t fraction = 0;  // of the value, in 2^-32; 0 unless a restored state had one
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
  bool has_reads = false;   // actions that read clocks
  // What an atom offers later follows from what it was when it last moved.
  bool is_foreseeable = false;
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

class Clocks {
 public:
  explicit Clocks(CoreParts& core) : core_(core) {}
  /// Sizes the tables, if the image has time. Once.
  void link();
  /// To instant 0, with all clocks at 0.
  void reset();

  [[nodiscard]] bool is_timed() const { return is_timed_; }
  /// 0 in images without time.
  [[nodiscard]] i64 now() const { return now_; }
  /// The shortest unit of all clocks, in ticks; a second without clocks.
  [[nodiscard]] i64 unit() const { return unit_; }

  // ---- letting time pass
  /// Lets time pass to an instant, no later than next_change() unless last_instant() comes first. False: a fault.
  bool advance(i64 to);
  /// The next instant at which a port may change by itself; kForever: none will.
  [[nodiscard]] i64 next_change() const { return changes_.first_key(); }
  /// The last instant that the invariants allow.
  [[nodiscard]] i64 last_instant() const { return ends_.first_key(); }
  /// Of a core that shares the system with others: goes to an instant that all of them agreed on. Appends the atoms
  /// whose ports may change there; nothing changes their ports, and nothing is foreseen of them any more.
  void pass_to(i64 to, std::vector<u32>& changed);
  /// Returns the last instant to which time may pass in this state, candidates' urgency and invariants considered; of
  /// each candidate the last instant of its interval. O(candidates); at an open bound, two restored states.
  i64 wait_limit(std::vector<i64>& ends);
  /// Of a candidate of this instant.
  CandidateTime time_of(const Candidate& candidate);
  /// Takes the step at this instant. False: a fault.
  bool take(EnabledSet::Position at);
  /// May time not pass this instant because an eager candidate begins right after it (`x > 5` at x = 5)? Such a
  /// candidate has no first instant, and would let no time pass at any of its instants. Looks at the next tick and
  /// comes back if a port changes there; the state stays as it is.
  [[nodiscard]] bool is_before_eager();
  /// Of an instant reached by time alone, a tick after the one before, with all atoms still busy that were so until
  /// then: is it the first of an eager candidate with an open bound? Returns the candidate's number, or their count.
  [[nodiscard]] u64 opened_eager();
  /// Can that be, in this model (may_open_eagerly)?
  [[nodiscard]] bool has_open_eager() const { return has_open_eager_; }
  /// Makes a fault of a state in which neither a step nor time can go on. Always false.
  bool fail_time_lock();
  /// Real time: says of a step that it was planned for now, could start until `last`, and starts at `actual`.
  [[nodiscard]] Fault late_step(const Candidate& candidate, i64 last, i64 actual) const;
  /// Makes that the fault in which the run ends. Always false.
  bool fail_late(const Candidate& candidate, i64 last, i64 actual);

  // ---- clocks
  /// Rows of all clocks that were set since the last restore or timed step began.
  [[nodiscard]] const std::vector<u32>& set_clocks() const { return set_clocks_; }
  [[nodiscard]] u32 first_clock(u32 atom) const { return clock_base_[atom]; }
  [[nodiscard]] const ClockState& clock_state(u32 row) const { return clocks_[row]; }
  /// A clock's value in ticks; clock: a row of the atom's type.
  [[nodiscard]] Int128 clock_value(u32 atom, u32 clock) const { return exact_value(atom, clock) >> 32; }

  // ---- for the other parts of the core
  /// Before `initial`: clocks run at speed 1.
  void start_clocks(u32 atom);
  /// Before an action: puts the values of clocks that actions read into their hidden variables.
  void show_clocks(u32 atom);
  /// Takes what an action said of the clocks out of the hidden variables. False: a fault.
  bool read_clocks(u32 atom, const Transition* fired);
  /// Evaluates the limits that are no constants into their hidden variables. False: a fault.
  bool measure_limits(u32 atom, const TimeGuard& when);
  /// Takes a measured limit out of its variable. False: it is no number, and compares with nothing.
  bool take_limit(u32 atom, const Bound& bound, i64& limit);
  /// After a step of the atom, internal transitions included: how long is it busy? fired: null for `initial`. False: a
  /// fault.
  bool begin_resume(u32 atom, const LinkedTransition* fired);
  /// From now on a busy atom goes on when resume_at() says so, and not at the first instant at which its `resume`
  /// holds.
  void wait_for_resume_at() { waits_for_resume_at_ = true; }
  /// From now on an atom resumes at a random instant of those at which its `resume` holds: uniform, or exponential
  /// with unit() as mean if there is no last one. Draws depend on the seed and on how many there were, which is part
  /// of the state. No effect without `resume`.
  void draw_resumes(u64 seed);
  [[nodiscard]] bool draws_resumes() const { return draws_resumes_; }
  /// Has an `initial` a `resume`?
  [[nodiscard]] bool has_initial_resume() const;
  /// Atoms that `resume` made busy in the last step that take() fired.
  [[nodiscard]] const std::vector<u32>& resuming() const { return resuming_; }
  /// A busy atom goes on at this instant (kForever: never), whatever its `resume` says. False: a fault.
  bool resume_at(u32 atom, i64 instant);
  /// The last instant at which the atom's `resume` lets it go on.
  [[nodiscard]] i64 may_resume_until(u32 atom) const { return may_resume_until_[atom]; }
  /// Real time: the actions of resuming() returned at `instant`, so none of these atoms resumes before it; one whose
  /// `resume` holds no longer then resumes at the last instant of it. False: a fault.
  bool returned_at(i64 instant);
  /// Has the transition of each participant that has time `resume`? Such a step may start late.
  [[nodiscard]] bool is_resumed(const Candidate& candidate);
  /// Real time: says of an atom that its action returned at `actual`, later than its `resume` allows.
  [[nodiscard]] Fault late_resume(u32 atom, i64 actual) const;
  /// Makes that the fault in which the run ends. Always false.
  bool fail_late_resume(u32 atom, i64 actual);
  /// Finds a timed atom's ports at this instant, and what is next. False: a fault.
  bool look_at_time(u32 atom);
  /// The same of an atom that is not offered in this core: its ports here stay as they are, what it offers is in
  /// AtomSteps::port_scratch() and port_time(). Of an atom whose action beside the others has not ended.
  bool find_ports(u32 atom);
  [[nodiscard]] const PortTime& port_time(u32 instance) const { return ports_[instance]; }
  void set_port_time(u32 instance, const PortTime& time) { ports_[instance] = time; }
  /// The next instant at which the atom's ports may change.
  [[nodiscard]] i64 next_change_of(u32 atom) const { return changes_.key(atom); }
  /// Of an atom from another core, which knows its invariants: until then it offers the same.
  void expect_change(u32 atom, i64 at) { changes_.set(atom, at); }
  /// The atom is at work, or is offered in another core: nothing is known of what it offers next.
  void forget(u32 atom);
  /// Before a step in which the port takes part. False: it is a fault.
  bool begin_port(u32 instance);
  /// Before an atom's action, in steps that are begun and finished apart.
  void begin_part() {
    set_clocks_.clear();
    resuming_.clear();
  }
  [[nodiscard]] i64 busy_until(u32 atom) const { return busy_until_[atom]; }
  void set_busy_until(u32 atom, i64 instant) { busy_until_[atom] = instant; }
  /// Appends now; of each clock its value and speed, and the fraction of the value if the speed has one; of each atom
  /// the instant until which it is busy; then what actions and events add, and how many instants were drawn if
  /// draws_resumes(). Reads the same.
  void save(std::vector<i64>& out) const;
  void load(const std::vector<i64>& in);
  /// Appends what `save` says of the clocks of an atom, and until when it is busy.
  void save_atom(u32 atom, std::vector<i64>& out) const;
  /// Are these such words?
  [[nodiscard]] bool is_saved(u32 atom, const std::vector<i64>& words) const;
  /// Are the tournaments in order, and is no atom's next change in the past? O(atoms).
  [[nodiscard]] bool is_consistent() const {
    return changes_.is_consistent() && ends_.is_consistent() && changes_.first_key() > now_;
  }
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const;

 private:
  void find_ports_that_begin();
  [[nodiscard]] Int128 exact_value(u32 atom, u32 clock) const;
  bool interval_of(u32 atom, const TimeGuard& when, Interval& out);
  bool resume_interval(u32 atom, const Resume& resume, Interval& out);
  bool resume_together(std::vector<u32>& rows);
  bool look_at_invariants(u32 atom);
  void enable_coming(u32 atom);
  bool find_ports(u32 atom, bool is_busy, i64& next, u32& possible);
  i64 draw_resume(i64 first, i64 last);
  /// To the next tick, as if who goes on there did not yet: in dense time all before it is like that. False: a fault.
  bool advance_while_busy();
  void describe_open_bound();
  bool fail_clock(u32 atom, const Clock& clock, const Transition* fired, const char* what, double value);

  CoreParts& core_;
  bool is_timed_ = false;
  bool has_sync_ = false;        // of some connector the ports resume together
  bool has_open_eager_ = false;  // an eager transition, and a bound with `<` or `>`
  i64 now_ = 0;
  i64 unit_ = 0;
  std::vector<u32> clock_base_;  // by atom, and the total
  std::vector<ClockState> clocks_;
  std::vector<i64> busy_until_;        // by atom; > now: no port is enabled before then
  std::vector<i64> may_resume_until_;  // by atom: the last instant of what its `resume` waited for
  std::vector<TypeTime> types_;        // by type of atoms
  std::vector<PortTime> ports_;        // by port instance
  std::vector<Coming> coming_;         // by atom, at the instant that `changes_` says
  bool waits_for_resume_at_ = false;
  bool draws_resumes_ = false;
  bool resumes_together_ = false;  // in the step that is under way: its participants get one instant
  u64 resume_seed_ = 0, resumes_drawn_ = 0;
  std::vector<u32> set_clocks_, resuming_;
  // Functions of the rest, brought up to date when an atom is looked at.
  TimeHeap changes_;  // by atom: the next instant at which its ports may change
  TimeHeap ends_;     // by atom: the last instant that its invariants allow
  std::vector<Participant> participant_scratch_;
  // By port instance: begin_port() has something to do. One byte for each, since a step asks it of all its ports.
  std::vector<std::uint8_t> needs_begin_;
};

}  // namespace bip::rt
