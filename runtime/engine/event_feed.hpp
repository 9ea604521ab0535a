// Where a run's events come from: a file, and in real time the clock on the wall that says when.
//
// The engine looks what is next, then asks whether something comes from outside before that. In logical time the answer follows
// from the events alone, so a run with the same events is the same run; in real time asking sleeps. Cost without ports for
// events: one comparison.
#pragma once
#include <string>
#include <vector>

#include "runtime/engine/event_file.hpp"
#include "runtime/engine/real_time.hpp"

namespace bip::rt {

class EventFeed {
 public:
  explicit EventFeed(const Core& core) : ports_(core) {}
  [[nodiscard]] const EventPorts& ports() const { return ports_; }

  /// The events of a file; once, before the first question. False: `error` says what is wrong.
  [[nodiscard]] bool read(const std::string& path, std::string& error) { return read_events(path, ports_, script_, error); }
  /// From now on waiting sleeps.
  void follow(RealTime& wall) { wall_ = &wall; }

  /// The engine has looked, and without us it goes on at `target`. The instant of the first event that comes until then, no
  /// earlier than now; kForever: none does, or is_stopped(). In real time it is then `target`.
  [[nodiscard]] i64 wait(const Core& core, i64 target);
  /// All events of this instant into the core. False: a fault.
  [[nodiscard]] bool deliver(Core& core);
  [[nodiscard]] bool is_stopped() const { return is_stopped_; }

 private:
  [[nodiscard]] bool is_due(const Event& event, i64 target) const;

  EventPorts ports_;
  std::vector<Event> script_;
  std::size_t next_ = 0;   // of script_
  u64 looks_ = 0;
  RealTime* wall_ = nullptr;
  bool is_stopped_ = false;
  std::vector<Slot> slots_;
};

}  // namespace bip::rt
