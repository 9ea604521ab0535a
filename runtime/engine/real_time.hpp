// Model time against the wall clock: sleeps to absolute deadlines and keeps how late each step was.
//
// An instant of the model is due at start + (instant - first) / speed on the system's monotonic clock, so lateness
// never adds up. Nothing here sleeps: the code that waits (event_feed.hpp) asks when an instant is due. Lateness is
// reported, never fed back: the run's steps and instants are those of logical time.
#pragma once
#include <array>
#include <atomic>
#include <string>

#include "runtime/core/time/interval.hpp"

namespace bip::rt {

class RealTime {
 public:
  /// Model seconds a second; > 0.
  explicit RealTime(double speed) : speed_(speed) {}
  /// The instant `first` of the model is now.
  void start(i64 first);
  /// The model's instant. Any thread, once started.
  [[nodiscard]] i64 now() const;
  /// When an instant is due on the wall clock; further away than it can say: kForever.
  [[nodiscard]] i64 due(i64 instant) const;
  [[nodiscard]] bool has_passed(i64 instant) const;
  /// A step of the instant starts: how late that is, in ns of the wall clock.
  i64 note_late(i64 instant);
  /// What `late` ns of the wall clock are in the model's time.
  [[nodiscard]] i64 in_model(i64 late) const { return static_cast<i64>(static_cast<double>(late) * speed_); }
  /// A step that was possible until `last` starts at `actual`: by more than a millisecond of the wall clock?
  [[nodiscard]] bool is_too_late(i64 actual, i64 last) const {
    return last < actual && actual - last > in_model(1'000'000);
  }
  /// Median, largest, and a line for each power of two of microseconds that occurred.
  void append_histogram(std::string& out) const;

 private:
  double speed_;
  std::atomic<i64> first_{0}, origin_{0};
  std::array<std::uint64_t, 48> late_{};  // [k]: below 2^k us and not below 2^(k-1) us
  i64 most_ = 0;
};

}  // namespace bip::rt
