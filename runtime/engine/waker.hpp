// Sleeping until an instant of the wall clock, or until another thread or a signal handler wakes the sleeper.
//
// A futex: the kernel compares the word before it lets a thread sleep, so no wake is lost between looking and sleeping,
// and no time is spent between. wake() costs a system call only if the thread sleeps. One thread sleeps.
#pragma once
#include <atomic>
#include <cstdint>

#include "runtime/core/time/interval.hpp"

namespace bip::rt {

class Waker {
 public:
  Waker() = default;
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;

  /// Any thread, or a signal handler.
  void wake() noexcept;
  /// The sleeper calls it before it looks for work: what is made known from now on wakes it.
  void prepare() noexcept { sleeps_.store(1, std::memory_order_seq_cst); }
  /// There is work.
  void stay_awake() noexcept { sleeps_.store(0, std::memory_order_relaxed); }
  /// Sleeps to an instant of CLOCK_MONOTONIC in ns, kForever for none, or until it is woken. After prepare().
  void sleep_until(i64 instant) noexcept;
  /// When the last sleep ended, on CLOCK_MONOTONIC in ns, 1 if there was none; 0: the thread sleeps. Any thread.
  [[nodiscard]] i64 awake_since() const noexcept { return awake_since_.load(std::memory_order_relaxed); }

 private:
  std::atomic<i64> awake_since_{1};
  std::atomic<std::uint32_t> sleeps_{0};  // 1: the thread sleeps, or is about to
};

/// CLOCK_MONOTONIC in ns.
[[nodiscard]] i64 wall_clock();

}  // namespace bip::rt
