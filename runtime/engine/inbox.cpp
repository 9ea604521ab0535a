// See inbox.hpp.
#include "runtime/engine/inbox.hpp"

#include "bip/assert.hpp"

namespace bip::rt {

// Under the lock: events are in the order of their instants.
void Inbox::add(Event event) {
  BIP_ASSERT(event.kind == EventKind::Port || event.job != 0, "an action without a job returns");
  events_.push_back(std::move(event));
  // Before the waker is asked whether its thread sleeps, in the one order of all such accesses.
  if (!has_events_.load(std::memory_order_relaxed)) has_events_.store(true, std::memory_order_seq_cst);
}

bool Inbox::post(u32 row, std::vector<EventValue> values, const RealTime* wall) {
  {
    const std::lock_guard<std::mutex> hold(lock_);
    BIP_ASSERT(row < waiting_.size(), "port {} of {}", row, waiting_.size());
    if (waiting_[row] >= capacity_) return false;
    ++waiting_[row];
    add({wall == nullptr ? 0 : wall->now(), row, kAnyLook, std::move(values), EventKind::Port, 0});
  }
  waker_.wake();
  return true;
}

void Inbox::note_return(u32 atom, u64 job, const RealTime& wall) {
  {
    const std::lock_guard<std::mutex> hold(lock_);
    add({wall.now(), atom, kAnyLook, {}, EventKind::Return, job});
  }
  waker_.wake();
}

void Inbox::take(std::deque<Event>& out) {
  if (!has_events_.load(std::memory_order_seq_cst)) return;
  {
    const std::lock_guard<std::mutex> hold(lock_);
    BIP_ASSERT(taken_.empty(), "{} events were not taken over", taken_.size());
    taken_.swap(events_);
    has_events_.store(false, std::memory_order_relaxed);
  }
  for (Event& event : taken_) out.push_back(std::move(event));
  taken_.clear();
}

void Inbox::restart(RealTime& wall, i64 now) {
  const std::lock_guard<std::mutex> hold(lock_);
  wall.start(now);
  for (Event& event : events_) event.time = now;
}

void Inbox::release(u32 row, u32 count) {
  const std::lock_guard<std::mutex> hold(lock_);
  waiting_[row] -= std::min(waiting_[row], count);
}

void Inbox::hold(u32 row, u32 count) {
  const std::lock_guard<std::mutex> hold(lock_);
  waiting_[row] += count;
}

}  // namespace bip::rt
