// When a node of a distributed run takes the steps of a model with time: the instants that it offers when all nodes
// rest, and which of its candidates may begin at the instant that follows.
//
// As with one node (timed_scheduler.hpp) the policy `uniform` plans every candidate at a random instant of its
// interval, and the other policies, and all with `asap`, take the first instant at which there is a candidate. The next
// instant of the whole system is the smallest one that a node plans or at which what it knows changes, and none beyond
// the last one that a node allows. What is planned for that instant may begin there, on all nodes at once; all other
// plans are drawn anew, which does not change how long one waits.
#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include "bip/prng.hpp"
#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/engine/scheduler.hpp"

namespace bip::rt {

/// What nodes know of time when all of them rest.
struct TimeLimit {
  i64 last = kForever;    // time must not pass this instant
  i64 change = kForever;  // the next instant at which a port may change
  void meet(const TimeLimit& other) {
    last = std::min(last, other.last);
    change = std::min(change, other.change);
  }
};

/// Does a run with these options draw the instants of its steps?
[[nodiscard]] bool plans_instants(const Core& core, const RunOptions& options);

/// Can neither a step nor time go on, in a state of the whole system? Then that is the core's fault.
[[nodiscard]] bool is_time_locked(Core& core);

class NodeTime {
 public:
  /// plans: `uniform` without `asap`.
  NodeTime(bool plans, u64 seed) : plans_(plans), prng_(~seed) {}

  /// Of a node that rests. O(candidates) if it plans.
  [[nodiscard]] TimeLimit limit(Core& core);
  /// After limit: draws the plans, none after `last`. Returns the earliest; kForever: there is none.
  [[nodiscard]] i64 plan(Core& core, i64 last);
  /// The instant that follows: what is planned for it may begin.
  void begin(i64 instant);
  /// Chooses a candidate that may begin now; `fired` follows if it does. False: there is none.
  [[nodiscard]] bool choose(Scheduler& scheduler, Core& core, EnabledSet::Position& at);
  void fired(InteractionId interaction);

 private:
  bool plans_;
  Prng prng_;
  std::vector<i64> ends_;                               // by candidate: the last instant of its interval
  std::vector<std::pair<i64, InteractionId>> planned_;  // instants of interactions
  std::vector<InteractionId> due_;                      // interactions that may begin
};

}  // namespace bip::rt
