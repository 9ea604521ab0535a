// The prover's clock: seconds that the processor has worked for this process, on all threads together.
//
// So an answer within a limit does not depend on what else the machine does, and a limit that two threads share is over
// in half the time. Reading it is a system call: look at it now and then, not at every step.
#pragma once
#include <chrono>
#include <ctime>

#include "runtime/engine/interrupt.hpp"

namespace bip::verify {

struct ProcessClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<ProcessClock>;
  static constexpr bool is_steady = true;
  [[nodiscard]] static time_point now() {
    std::timespec spent{};
    (void)::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &spent);
    return time_point(std::chrono::seconds(spent.tv_sec) + std::chrono::nanoseconds(spent.tv_nsec));
  }
};

/// From now on.
[[nodiscard]] inline ProcessClock::time_point seconds_from_now(double seconds) {
  return ProcessClock::now() +
         std::chrono::duration_cast<ProcessClock::duration>(std::chrono::duration<double>(seconds));
}
/// None are left after Ctrl-C.
[[nodiscard]] inline double seconds_until(ProcessClock::time_point end) {
  return rt::is_interrupted() ? 0 : std::chrono::duration<double>(end - ProcessClock::now()).count();
}

}  // namespace bip::verify
