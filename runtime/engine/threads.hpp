// The threaded engine: steps begin one after the other, the actions of their transitions run on several threads.
//
// A free thread does what is next, under one lock: finishes what it ran, begins a step (a candidate in the partial
// state that does not depend on atoms at work, core/partial.hpp), and runs one of the actions outside of the lock. So
// there is no thread that only schedules, and while all are busy none is woken. In the order in which they began the
// steps are a sequential run; lines and trace have that order, and end where a sequential run would meet a fault.
// Actions that turn out to take less than kShort run at once, under the lock: handing them over would cost more.
#pragma once
#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/engine/scheduler.hpp"

namespace bip::rt {

struct ThreadedResult {
  End end = End::Limit;
  std::uint64_t steps = 0;
  std::uint32_t threads = 0, most_busy = 0;  // atoms at work at once
  std::uint64_t handed_over = 0;             // actions that ran outside of the lock
};

/// Of an initialized core without time whose scheduler was started. core.fault() has the fault, if there is one.
[[nodiscard]] ThreadedResult run_threads(Core& core, Scheduler& scheduler, const RunOptions& options, Output& output);

}  // namespace bip::rt
