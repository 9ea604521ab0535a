// See event_feed.hpp.
#include "runtime/engine/event_feed.hpp"

#include "runtime/engine/interrupt.hpp"

namespace bip::rt {

// A recorded event came after the look that its line names, whatever the instants say.
bool EventFeed::is_due(const Event& event, i64 target) const { return event.look == kAnyLook ? event.time <= target : event.look <= looks_; }

i64 EventFeed::wait(const Core& core, i64 target) {
  ++looks_;
  const bool has_next = next_ < script_.size();
  const bool is_next_due = has_next && is_due(script_[next_], target);
  const i64 until = is_next_due ? std::max(script_[next_].time, core.now()) : target;
  if (wall_ != nullptr && until != kForever) {
    wall_->sleep_until(until);
    is_stopped_ = is_interrupted();
    if (is_stopped_) return kForever;
  }
  return is_next_due ? until : kForever;
}

bool EventFeed::deliver(Core& core) {
  for (; next_ < script_.size() && is_due(script_[next_], core.now()); ++next_) {
    ports_.to_slots(script_[next_].row, script_[next_].values, slots_);
    if (!core.deliver(script_[next_].row, slots_.data())) return false;
  }
  return true;
}

}  // namespace bip::rt
