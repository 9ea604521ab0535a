// How late may a step of a state start, in real time? Asked of each step, and nearly always no port that is enabled
// limits it.
//
// The answer of TimedScheduler::latest() looks at each candidate, for one that is urgent bounds the others. Here the
// ports that could be urgent or could have an end are looked at first: those whose transitions say so, a few of the
// model. If none of them is enabled with a limit, all candidates wait as long as the invariants let them.
#pragma once
#include <vector>

#include "runtime/core/core.hpp"
#include "runtime/engine/timed_scheduler.hpp"

namespace bip::rt {

class LimitingPorts {
 public:
  /// O(ports).
  explicit LimitingPorts(const Core& core);
  /// Returns what scheduler.latest(core) does. O(limiting ports) where none of them limits, or O(candidates).
  [[nodiscard]] i64 latest(Core& core, TimedScheduler& scheduler) const;

 private:
  std::vector<u32> ports_;  // instances
};

}  // namespace bip::rt
