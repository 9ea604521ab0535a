// See event_feed.hpp.
#include "runtime/engine/event_feed.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/engine/collect_strings.hpp"
#include "runtime/engine/overrun.hpp"

namespace bip::rt {

namespace {
// Real time: so often the engine may look at an instant whose steps do not end while an event of a later one waits.
constexpr u32 kMaxStalls = 64;
// While the model takes the events of a full queue, the inbox is notified so many times that it has room again.
constexpr u32 kReleases = 64;
// Actions at work at once; others wait for a thread.
constexpr u32 kMostThreads = 64;
}  // namespace

void EventFeed::follow(RealTime& wall) {
  wall_ = &wall;
  engine_.wall = &wall;
  passed_ = -1;
}

// Steps of an instant after the first one do not read the clock.
bool EventFeed::has_passed(i64 instant) {
  if (instant <= passed_) return true;
  if (!wall_->has_passed(instant)) return false;
  passed_ = instant;
  return true;
}

void EventFeed::restart(RealTime& wall, i64 now) {
  passed_ = -1;
  inbox_.restart(wall, now);
  for (Event& event : arrived_) event.time = now;
}

bool EventFeed::open_sources(Core& core) {
  engine_.waker = &inbox_.waker();
  return sources_.open(core, ports_, engine_) || fail(core);
}

bool EventFeed::fail(Core& core) {
  failed_ = true;
  return core.events().fail_outside(FaultCode::SourceFailed, sources_.problem());
}

void EventFeed::open_inbox() {
  is_open_ = true;
  held_.assign(ports_.size(), 0);
}

void EventFeed::stop() {
  wants_stop_.store(true);
  inbox_.waker().wake();
}

void EventFeed::open_pool(Core& core) {
  if (!core.actions().any() || wall_ == nullptr) return;
  pool_ =
      std::make_unique<ActionPool>(kMostThreads, [this](u32 atom, u64 job) { inbox_.note_return(atom, job, *wall_); });
  core.actions().await_returns(pool_.get());
}

Result<bool> EventFeed::read(const std::string& path, bool (*stops)()) {
  const Result<bool> is_read = take_script(path, EventSource::Script, stops);
  for (Event& event : script_) event.look = kAnyLook;
  return is_read;
}

Result<bool> EventFeed::replay(const std::string& path, bool (*stops)()) {
  return take_script(path, EventSource::Record, stops);
}

Result<bool> EventFeed::take_script(const std::string& path, EventSource source, bool (*stops)()) {
  Result<std::vector<Event>> events = read_events(path, ports_, source, stops);
  if (!events) return Failure{events.error()};
  script_ = std::move(*events);
  return true;
}

// A recorded event came after the look that its line names, whatever the instants say.
bool EventFeed::is_due(const Event& event, i64 target) const {
  return event.look == kAnyLook ? event.time <= target : event.look <= looks_;
}

// Jobs of a state that was left are nothing.
void EventFeed::forget_jobs(const Core& core, std::size_t first) {
  if (first == arrived_.size()) return;
  const auto begin = arrived_.begin() + static_cast<std::ptrdiff_t>(first);
  arrived_.erase(std::remove_if(begin, arrived_.end(),
                                [&](const Event& e) {
                                  return e.kind != EventKind::Port && !(core.actions().is_at_work(e.row) &&
                                                                        core.actions().work_of(e.row).job == e.job);
                                }),
                 arrived_.end());
}

// Whose budget is over, by what arrived from row `first` on and by the clock. The news comes before the return.
void EventFeed::look_at_budgets(Core& core, std::size_t first) {
  BIP_ASSERT(first <= arrived_.size() && wall_ != nullptr, "events from {} on, of {}", first, arrived_.size());
  for (std::size_t k = first; k < arrived_.size(); ++k) {
    if (arrived_[k].kind != EventKind::Return) continue;
    const Event event = arrived_[k];
    BIP_ASSERT(core.actions().is_at_work(event.row), "atom {} is not at work", event.row);
    if (event.time > core.actions().work_of(event.row).until && !core.actions().work_of(event.row).is_overrun) {
      arrived_.insert(
          arrived_.begin() + static_cast<std::ptrdiff_t>(k++),
          {core.actions().work_of(event.row).until, event.row, kAnyLook, {}, EventKind::Overrun, event.job});
    }
    core.actions().mark_overrun(event.row);
  }
  if (core.actions().working().empty()) return;
  const i64 now = wall_->now();
  for (u32 atom = next_overrun(core); atom != kNone && core.actions().work_of(atom).until <= now;
       atom = next_overrun(core)) {
    arrived_.push_back(
        {core.actions().work_of(atom).until, atom, kAnyLook, {}, EventKind::Overrun, core.actions().work_of(atom).job});
    core.actions().mark_overrun(atom);
  }
}

// What came from classes and threads, sorted by its instants.
bool EventFeed::collect(Core& core, i64 until) {
  if (pool_ != nullptr) forget_jobs(core, 0);
  const std::size_t before = arrived_.size();
  if (!sources_.empty() && !sources_.poll(core, ports_, until, arrived_)) return fail(core);
  if (is_open_ || pool_ != nullptr) inbox_.take(arrived_);
  if (pool_ != nullptr) {
    forget_jobs(core, before);
    look_at_budgets(core, before);
  }
  if (arrived_.size() == before) return true;
  const auto is_earlier = [](const Event& a, const Event& b) { return a.time < b.time; };
  bool is_sorted = true;
  for (std::size_t k = before; k < arrived_.size(); ++k) {
    arrived_[k].time = std::max(arrived_[k].time, core.now());
    is_sorted = is_sorted && (k == 0 || !is_earlier(arrived_[k], arrived_[k - 1]));
  }
  // Threads' events are; sorting thousands that wait for each that comes is not for free.
  if (!is_sorted) std::stable_sort(arrived_.begin(), arrived_.end(), is_earlier);
  BIP_ASSERT(std::is_sorted(arrived_.begin(), arrived_.end(), is_earlier), "events out of order");
  return true;
}

// Tells the inbox what the core holds no longer.
void EventFeed::release(const Core& core) {
  for (std::size_t k = 0; k < active_.size();) {
    const u32 row = active_[k];
    BIP_ASSERT(row < held_.size(), "port {} of {}", row, held_.size());
    const u32 waiting = core.events().waiting(row);
    // Not for each one: that is a lock that those who post want, too.
    if (waiting != 0 && held_[row] - waiting < inbox_.capacity() / kReleases) {
      ++k;
      continue;
    }
    BIP_ASSERT(waiting <= held_[row], "{} events wait at port {}, {} came", waiting, row, held_[row]);
    if (waiting < held_[row]) inbox_.release(row, held_[row] - waiting);
    held_[row] = waiting;
    if (waiting != 0) {
      ++k;
    } else {
      active_[k] = active_.back();
      active_.pop_back();
    }
  }
}

void EventFeed::recount(const Core& core) {
  if (!is_open_) return;
  active_.clear();
  for (u32 row = 0; row < held_.size(); ++row) {
    const u32 waiting = core.events().waiting(row);
    if (waiting > held_[row]) inbox_.hold(row, waiting - held_[row]);
    else if (waiting < held_[row]) inbox_.release(row, held_[row] - waiting);
    held_[row] = waiting;
    if (waiting != 0) active_.push_back(row);
  }
}

i64 EventFeed::wait_for_outside(Core& core, i64 target) {
  BIP_ASSERT(target >= core.now(), "waits at {} for {}", core.now(), target);
  ++looks_;
  gave_up_ = false;
  release(core);
  engine_.instant.store(core.now(), std::memory_order_relaxed);
  stalls_ = target == core.now() && !arrived_.empty() ? stalls_ + 1 : 0;
  // The first look does not announce a sleep: most looks find something, and a post would pay for waking this thread.
  bool is_prepared = false;
  while (true) {
    if (is_prepared) waker().prepare();
    if (!collect(core, target)) return kForever;
    i64 event = kForever;
    if (next_ < script_.size() && is_due(script_[next_], target)) event = script_[next_].time;
    if (!arrived_.empty() && (arrived_.front().time <= target || stalls_ > kMaxStalls))
      event = std::min({event, arrived_.front().time, target});
    if (event != kForever && next_ < script_.size() && script_[next_].look != kAnyLook &&
        (script_[next_].look != looks_ || script_[next_].kind == EventKind::Resume || event < core.now() ||
         event > target)) {
      failed_ = true;
      const Event& next = script_[next_];
      const std::string what = next.kind == EventKind::Resume ? std::string("an action of `resume` returned")
                               : next.kind == EventKind::Port
                                   ? "the event for port `" + ports_.path(next.row) + '`'
                                   : std::string("what ended in `") + ports_.atom_path(next.row) + '`';
      (void)core.events().fail_outside(FaultCode::ReplayDiffers,
                                       "the run differs from what was recorded before " + what);
      return kForever;
    }
    const i64 until = event == kForever ? target : std::max(event, core.now());
    const bool comes = event != kForever;
    const bool may_come = is_open_ || !sources_.empty() || (pool_ != nullptr && !core.actions().working().empty());
    const bool is_over = wall_ == nullptr || has_passed(until) || (until == kForever && !may_come);
    // What is due comes before what stop() wants.
    gave_up_ = is_interrupted() || (!is_over && wants_stop_.load());
    if (is_prepared && (is_over || gave_up_)) waker().stay_awake();
    if (gave_up_) {
      --looks_;
      return kForever;
    }
    BIP_ASSERT(until >= core.now(), "waits at {} for {}", core.now(), until);
    if (is_over) return comes ? until : kForever;
    if (!is_prepared) {
      is_prepared = true;
      continue;
    }
    const u32 late = pool_ != nullptr ? next_overrun(core) : kNone;
    waker().sleep_until(wall_->due(late == kNone ? until : std::min(until, core.actions().work_of(late).until)));
  }
}

bool EventFeed::deliver(Core& core) {
  for (; next_ < script_.size() && is_due(script_[next_], core.now()); ++next_) {
    if (!deliver(core, script_[next_])) return false;
  }
  while (!arrived_.empty() && (arrived_.front().time <= core.now() || stalls_ > kMaxStalls)) {
    const Event event = std::move(arrived_.front());
    arrived_.pop_front();
    BIP_ASSERT(arrived_.empty() || event.time <= arrived_.front().time, "an event at {} before one at {}", event.time,
               arrived_.front().time);
    if (!deliver(core, event)) return false;
    if (event.kind != EventKind::Port) continue;
    if (is_open_ && held_[event.row]++ == 0) active_.push_back(event.row);
    if (!sources_.delivered(core, event.row)) return fail(core);
  }
  // Events that no port takes make no step.
  collect_strings(core);
  return true;
}

bool EventFeed::hold_until_return(Core& core) {
  Event event{core.now(), 0, looks_ + 1, {}, EventKind::Resume, 0, 0};
  if (wall_ != nullptr) {
    event.until = std::max(wall_->now(), core.now());
    return deliver(core, event);
  }
  if (next_ >= script_.size() || script_[next_].kind != EventKind::Resume || script_[next_].look != event.look)
    return true;
  event.until = script_[next_++].until;
  return deliver(core, event);
}

// Do all atoms that `resume` holds go on in time if their actions returned at the instant? By more than a millisecond
// of the wall clock, that is; a replay tells of returns that were in time.
bool EventFeed::is_in_time(Core& core, i64 instant) {
  for (const u32 atom : core.time().resuming()) {
    if (wall_ == nullptr || !wall_->is_too_late(instant, core.time().may_resume_until(atom))) continue;
    if (!is_relaxed_) return core.time().fail_late_resume(atom, instant);
    if (warnings_ == nullptr) continue;
    const std::string text = core.time().late_resume(atom, instant).what;
    std::fprintf(warnings_, "warning: %s\n", text.c_str());
  }
  return true;
}

// Reports the overrun, and posts an event to the port that the transition names for it.
bool EventFeed::overrun(Core& core, u32 atom) {
  if (!core.actions().is_at_work(atom))
    return core.events().fail_outside(FaultCode::ReplayDiffers,
                                      std::string("nothing runs in `") + ports_.atom_path(atom) + '`');
  ++overruns_;
  core.actions().mark_overrun(atom);
  if (warnings_ != nullptr) {
    const std::string text = overrun_text(core, atom);
    std::fprintf(warnings_, "warning[R0045]: %s\n", text.c_str());
  }
  const u32 port = overrun_port(core, atom);
  return port == kNone || core.events().deliver(port, nullptr);
}

bool EventFeed::deliver(Core& core, const Event& event) {
  last_delivery_ = looks_;
  if (record_ != nullptr) {
    std::string line;
    const u64 look = event.kind == EventKind::Resume ? looks_ + 1 : looks_;
    append_event(line, ports_, {core.now(), event.row, look, event.values, event.kind, 0, event.until});
    record_->write(line);
  }
  if (noted_ != nullptr) noted_->push_back(event);
  return redeliver(core, event);
}

bool EventFeed::is_record_over(const Core& core) const {
  if (next_ < script_.size()) return false;
  if (script_.empty()) return true;
  const Event& last = script_.back();
  if (core.now() > last.time || looks_ > last_delivery_ + kMostLooksBehind) return true;
  for (u32 row = 0; row < ports_.size(); ++row) {
    if (core.events().waiting(row) != 0) return false;
  }
  return true;
}

void EventFeed::rewind(std::size_t delivered) {
  BIP_ASSERT(delivered <= script_.size(), "{} events of {}", delivered, script_.size());
  next_ = delivered;
  failed_ = false;
  // A record tells after which look an event came: of the run that was recorded, not of one that left it.
  for (std::size_t k = next_; k < script_.size(); ++k) script_[k].look = kAnyLook;
}

bool EventFeed::redeliver(Core& core, const Event& event) {
  if (event.kind == EventKind::Overrun) return overrun(core, event.row);
  if (event.kind == EventKind::Resume)
    return is_in_time(core, event.until) && core.time().returned_at(std::max(event.until, core.now()));
  BIP_ASSERT(event.kind == EventKind::Return || event.row < ports_.size(), "port {} of {}", event.row, ports_.size());
  if (event.kind == EventKind::Return) {
    if (!core.actions().is_at_work(event.row))
      return core.events().fail_outside(FaultCode::ReplayDiffers,
                                        std::string("nothing runs in `") + ports_.atom_path(event.row) + '`');
    return core.actions().return_action(event.row);
  }
  ports_.to_cells(event.row, event.values, cells_);
  return core.events().deliver(event.row, cells_.data());
}

}  // namespace bip::rt
