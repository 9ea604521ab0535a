// Events, and what tells that actions have ended, on their way from other threads to the engine, with a bound on what
// waits for each port, so that a thread that posts faster than the model takes does not fill the memory. A post to a
// full queue is refused; no accepted event is lost.
//
// Any thread posts, one thread takes. Cost of a post: a lock held for a move, and a system call if the engine sleeps;
// of a look that finds nothing: a load.
#pragma once
#include <atomic>
#include <deque>
#include <mutex>

#include "runtime/engine/event_file.hpp"
#include "runtime/engine/real_time.hpp"
#include "runtime/engine/waker.hpp"

namespace bip::rt {

class Inbox {
 public:
  Inbox(std::size_t ports, u32 capacity) : capacity_(capacity), waiting_(ports, 0) {}

  /// False: `capacity` events for the port wait here or in the core. The event's instant is that of `wall`, else that
  /// at which it is taken.
  [[nodiscard]] bool post(u32 row, std::vector<EventValue> values, const RealTime* wall);
  /// A job of the atom has ended, now.
  void note_return(u32 atom, u64 job, const RealTime& wall);
  /// Moves all that came to the end of `out`, in their order. A post that is not among them wakes the thread that has
  /// prepared to sleep.
  void take(std::deque<Event>& out);
  /// Starts the clock anew at an instant, which becomes that of all events that are here.
  void restart(RealTime& wall, i64 now);
  /// `count` events of the port left the core.
  void release(u32 row, u32 count);
  /// `count` events of the port are in the core that were not: it was set to another state.
  void hold(u32 row, u32 count);
  [[nodiscard]] Waker& waker() { return waker_; }
  [[nodiscard]] const Waker& waker() const { return waker_; }
  [[nodiscard]] u32 capacity() const { return capacity_; }

 private:
  void add(Event event);

  u32 capacity_;
  std::mutex lock_;
  std::atomic<bool> has_events_{false};  // written under the lock
  std::vector<Event> events_;
  std::vector<u32> waiting_;  // by row
  std::vector<Event> taken_;  // the engine's; its memory is used again
  Waker waker_;
};

}  // namespace bip::rt
