// See node_time.hpp.
#include "runtime/engine/node_time.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/time/draw_instant.hpp"
#include "runtime/engine/policies.hpp"

namespace bip::rt {

bool plans_instants(const Core& core, const RunOptions& options) {
  return core.is_timed() && row_of(options.policy).is_uniform() && !options.asap;
}

bool is_time_locked(Core& core) {
  if (!core.is_timed() || core.candidate_count() != 0) return false;
  std::vector<i64> ends;
  return core.time().next_change() > core.time().wait_limit(ends) && !core.time().fail_time_lock();
}

TimeLimit NodeTime::limit(Core& core) {
  Clocks& time = core.time();
  const i64 last = plans_ ? time.wait_limit(ends_) : time.last_instant();
  return {last, time.next_change()};
}

i64 NodeTime::plan(Core& core, i64 last) {
  planned_.clear();
  due_.clear();
  i64 first = kForever;
  if (!plans_) return first;
  BIP_ASSERT(ends_.size() == core.candidate_count(), "{} ends of {} candidates", ends_.size(), core.candidate_count());
  for (u64 k = 0; k < ends_.size(); ++k) {
    const i64 end = std::max(core.now(), std::min(ends_[k], last));
    const i64 instant = draw_instant(prng_, core.now(), end, core.time().unit());
    planned_.emplace_back(instant, core.position(k).interaction);
    first = std::min(first, instant);
  }
  return first;
}

void NodeTime::begin(i64 instant) {
  for (const auto& [at, interaction] : planned_) {
    if (at == instant && std::find(due_.begin(), due_.end(), interaction) == due_.end()) due_.push_back(interaction);
  }
  planned_.clear();
}

bool NodeTime::choose(Scheduler& scheduler, Core& core, EnabledSet::Position& at) {
  if (!plans_ || !core.is_timed()) return scheduler.choose_decided(core, at);
  const std::size_t count = due_.size();
  const std::size_t first = count < 2 ? 0 : prng_.below(count);
  for (std::size_t tried = 0; tried < count; ++tried) {
    const InteractionId interaction = due_[(first + tried) % count];
    if (core.enabled().weight(interaction) == 0 || !core.partial().is_decided(interaction)) continue;
    at = scheduler.choose_of(core, interaction);
    return true;
  }
  return false;
}

void NodeTime::fired(InteractionId interaction) {
  if (const auto at = std::find(due_.begin(), due_.end(), interaction); at != due_.end()) due_.erase(at);
}

}  // namespace bip::rt
