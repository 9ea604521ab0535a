// When is the next step, and which? Lets time pass until a step is due or an event comes (semantics.md, Time, Events).
//
// `uniform` plans every candidate at a random instant of its interval and takes the earliest; the other policies, and
// all with `asap`, take the first instant at which there is a candidate. Plans are drawn anew at each instant at which
// something changes: uniform and exponential waiting times forget how long one waited, so the distribution is the same
// and nothing is kept.
#pragma once
#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "bip/prng.hpp"
#include "runtime/engine/event_feed.hpp"
#include "runtime/engine/scheduler.hpp"

namespace bip::rt {

/// Event: some were delivered at this instant, and it is not decided what is next. Stopped: by a signal, before
/// anything was.
enum class Due : std::uint8_t { Step, Event, Deadlock, Fault, Stopped };

/// Does a run with these options draw the instants at which busy atoms resume? In logical time on one node where it
/// plans instants, and if an atom of the image has `resume`.
[[nodiscard]] bool draws_resumes(const Image& image, const RunOptions& options);

class TimedScheduler {
 public:
  TimedScheduler(Policy policy, bool asap, std::uint64_t seed)
      : scheduler_(policy, seed), plans_(scheduler_.is_uniform() && !asap), seed_(seed), prng_(~seed) {}

  /// Before the core finds the initial state of a run in logical time: where instants are planned, those at which busy
  /// atoms resume are drawn as well.
  void prepare(Core& core) const {
    if (plans_ && core.is_timed()) core.time().draw_resumes(seed_);
  }

  /// Lets time pass until a step is due; choice() is it. Without time one is due at once. Deadlock: there never will be
  /// one.
  Due wait(Core& core, EventFeed& feed);
  [[nodiscard]] EnabledSet::Position choice() const { return choice_; }
  /// The last instant at which it may be taken, before it is. O(candidates).
  [[nodiscard]] i64 latest(Core& core);
  /// Once, after the initial state is known.
  void start(Core& core) const { scheduler_.start(core); }
  void fired(InteractionId interaction) { scheduler_.fired(interaction); }
  /// The scheduler of models without time.
  [[nodiscard]] Scheduler& untimed() { return scheduler_; }

 private:
  /// What happens next if nothing comes from outside, at the instant at_: a step, a change of what is enabled, nothing
  /// more, or no time may pass beyond it.
  enum class Next : std::uint8_t { Step, Change, Never, Lock };
  Next look(Core& core);
  bool plan(Core& core, i64 last);

  Scheduler scheduler_;
  bool plans_;
  std::uint64_t seed_;
  Prng prng_;  // of instants; which candidate is the scheduler's
  EnabledSet::Position choice_{};
  i64 at_ = 0;
  std::vector<i64> ends_;  // by candidate: the last instant of its interval
};

}  // namespace bip::rt
