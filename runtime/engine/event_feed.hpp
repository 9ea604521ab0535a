// Where a run's events come from: a file, or C++ classes and other threads; and in real time the clock on the wall that
// says when.
//
// The engine looks what is next, then asks whether something comes from outside before that. In logical time the answer
// follows from the events alone, so a run with the same events is the same run; in real time asking sleeps, and uses no
// time while nothing comes. What is delivered can be recorded: the instants, and after which look. Cost without ports
// for events: a comparison.
#pragma once
#include <cstdio>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "runtime/core/fire/action_pool.hpp"
#include "runtime/engine/event_sources.hpp"
#include "runtime/engine/inbox.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/run_file.hpp"

namespace bip::rt {

class EventFeed {
 public:
  static constexpr u32 kCapacity = 1u << 16;
  static constexpr u64 kMostLooksBehind = 1000;
  explicit EventFeed(const Core& core, u32 capacity = kCapacity) : ports_(core), inbox_(ports_.size(), capacity) {}
  [[nodiscard]] const EventPorts& ports() const { return ports_; }

  /// The events of a file, and nothing else; once, before the first question. `stops`: as is_stopped of read_events.
  [[nodiscard]] Result<bool> read(const std::string& path, bool (*stops)() = nullptr);
  /// Those of a record, each after the look after which it came.
  [[nodiscard]] Result<bool> replay(const std::string& path, bool (*stops)() = nullptr);
  /// Makes the objects of the model's classes. False: a fault.
  [[nodiscard]] bool open_sources(Core& core);
  /// Threads may post from now on: in real time their events are waited for, however long.
  void open_inbox();
  /// Real time, after follow: actions that run beside the others (`@async`) have threads, and are waited for.
  void open_pool(Core& core);
  /// Where an action that has used up its budget is reported; null: nowhere.
  void warn(std::FILE* file) { warnings_ = file; }
  /// An action that returns later than its `resume` allows is a warning instead of a fault.
  void relax() { is_relaxed_ = true; }
  [[nodiscard]] u64 overruns() const { return overruns_; }
  /// From now on waiting sleeps.
  void follow(RealTime& wall);
  /// Each event that is delivered is written as a line; the file stays the caller's.
  void record(RunFile* file) { record_ = file; }
  /// Each event that is delivered is appended; null: nowhere.
  void note_into(std::vector<Event>* delivered) { noted_ = delivered; }
  /// Delivers an event again that was noted, in the state in which it was delivered. False: a fault.
  [[nodiscard]] bool redeliver(Core& core, const Event& event);
  /// The events of the file or record after the first `delivered` ones are still to come, each at its instant.
  void rewind(std::size_t delivered);

  /// Any thread, after open_inbox. Values as EventPorts::check wants them. False: too many wait for the port.
  [[nodiscard]] bool post(u32 row, std::vector<EventValue> values) {
    return inbox_.post(row, std::move(values), wall_);
  }
  /// Any thread: a wait returns, and is_stopped() holds.
  void stop();
  void go_on() { wants_stop_.store(false); }
  /// The core was set to another state: the events that wait in it are counted anew.
  void recount(const Core& core);
  /// The instant `now` of the model is now on the wall, and events that wait come now.
  void restart(RealTime& wall, i64 now);
  [[nodiscard]] Waker& waker() { return inbox_.waker(); }
  [[nodiscard]] const Waker& waker() const { return inbox_.waker(); }

  /// The engine has looked, and without us it goes on at `target`. The instant of the first event that comes until
  /// then, no earlier than now; kForever: none does, or is_stopped(), or failed(). In real time it is then `target`.
  [[nodiscard]] i64 wait(Core& core, i64 target) {
    if (ports_.size() != 0 || wall_ != nullptr || !script_.empty()) return wait_for_outside(core, target);
    // Nothing comes from outside, and no thread sleeps.
    gave_up_ = is_interrupted();
    looks_ += gave_up_ ? 0 : 1;
    return kForever;
  }
  /// After each step. In real time an atom that `resume` holds goes on no earlier than its action has returned; a
  /// replay says when that was. False: a fault.
  [[nodiscard]] bool resume(Core& core) {
    return !core.is_timed() || core.time().resuming().empty() || hold_until_return(core);
  }
  /// All events of this instant into the core. False: a fault.
  [[nodiscard]] bool deliver(Core& core);
  [[nodiscard]] bool is_stopped() const { return gave_up_; }
  /// A class threw; the core has the fault.
  [[nodiscard]] bool failed() const { return failed_; }
  /// How often the engine asked and was answered.
  [[nodiscard]] u64 looks() const { return looks_; }
  /// Of a record without its end: does it say nothing of what follows? So it is when its last event has been taken, or
  /// an instant has come that is later, or the steps of that instant go on for kMostLooksBehind looks.
  [[nodiscard]] bool is_record_over(const Core& core) const;

 private:
  [[nodiscard]] i64 wait_for_outside(Core& core, i64 target);
  [[nodiscard]] bool is_due(const Event& event, i64 target) const;
  [[nodiscard]] bool has_passed(i64 instant);
  bool collect(Core& core, i64 until);
  bool deliver(Core& core, const Event& event);
  bool hold_until_return(Core& core);
  Result<bool> take_script(const std::string& path, EventSource source, bool (*stops)());
  bool is_in_time(Core& core, i64 instant);
  bool overrun(Core& core, u32 atom);
  void forget_jobs(const Core& core, std::size_t first);
  void look_at_budgets(Core& core, std::size_t first);
  void release(const Core& core);
  bool fail(Core& core);

  EventPorts ports_;
  std::vector<Event> script_;
  std::size_t next_ = 0;  // of script_
  Inbox inbox_;
  EventSources sources_;
  EventSources::Engine engine_;
  std::deque<Event> arrived_;          // in the order of their instants
  std::vector<u32> held_;              // by row: posted events in the core, when we looked last
  std::vector<u32> active_;            // rows of which there are some
  u64 looks_ = 0, last_delivery_ = 0;  // the looks before it
  u32 stalls_ = 0;
  RealTime* wall_ = nullptr;
  i64 passed_ = -1;  // the last instant of the model of which it is known that the wall clock has passed it
  RunFile* record_ = nullptr;
  std::vector<Event>* noted_ = nullptr;
  bool is_open_ = false, failed_ = false;
  bool gave_up_ = false, is_relaxed_ = false;
  std::atomic<bool> wants_stop_{false};
  std::vector<Cell> cells_;
  std::FILE* warnings_ = nullptr;
  u64 overruns_ = 0;
  std::unique_ptr<ActionPool> pool_;  // the last: its threads reach the rest
};

}  // namespace bip::rt
