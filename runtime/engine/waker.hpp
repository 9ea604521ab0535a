// Sleeping until an instant of the wall clock, or until somebody wakes: another thread, or a signal handler.
//
// An eventfd and poll: no wake is lost between looking and sleeping, and no time is spent between. wake() costs a system call only
// if somebody sleeps.
#pragma once
#include <atomic>

#include "runtime/core/interval.hpp"

namespace bip::rt {

class Waker {
 public:
  Waker();
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;
  ~Waker();

  /// Any thread, or a signal handler.
  void wake() noexcept;
  /// Who sleeps calls it before he looks whether there is work: what is made known from now on wakes him.
  void prepare() noexcept { sleeps_.store(true, std::memory_order_seq_cst); }
  /// There is work.
  void stay_awake() noexcept { sleeps_.store(false, std::memory_order_relaxed); }
  /// Sleeps to an instant of CLOCK_MONOTONIC in ns, kForever for none, or until it is woken. After prepare().
  void sleep_until(i64 instant) noexcept;

 private:
  int file_;
  std::atomic<bool> sleeps_{false};
};

/// CLOCK_MONOTONIC in ns.
[[nodiscard]] i64 wall_clock();

}  // namespace bip::rt
