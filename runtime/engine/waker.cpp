// See waker.hpp.
#include "runtime/engine/waker.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

namespace bip::rt {

namespace {
constexpr i64 kSecond = 1'000'000'000;
// Longer sleeps are cut: a year is as good as for ever.
constexpr i64 kLongest = 365 * 24 * 3600 * kSecond;
}  // namespace

i64 wall_clock() {
  timespec at{};
  clock_gettime(CLOCK_MONOTONIC, &at);
  return static_cast<i64>(at.tv_sec) * kSecond + at.tv_nsec;
}

void Waker::wake() noexcept {
  // A thread that posts without pause finds the other one awake, and writes to nothing that other threads read.
  if (sleeps_.load(std::memory_order_seq_cst) == 0 || sleeps_.exchange(0, std::memory_order_seq_cst) == 0) return;
  const int before = errno;
  (void)::syscall(SYS_futex, &sleeps_, FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0);
  errno = before;
}

void Waker::sleep_until(i64 instant) noexcept {
  const i64 end = instant == kForever ? wall_clock() + kLongest : instant;
  const timespec until{static_cast<std::time_t>(end / kSecond), static_cast<long>(end % kSecond)};
  awake_since_.store(0, std::memory_order_relaxed);
  // An instant that has passed times out at once; a wake since prepare() has changed the word.
  while (sleeps_.load(std::memory_order_seq_cst) != 0) {
    if (::syscall(SYS_futex, &sleeps_, FUTEX_WAIT_BITSET_PRIVATE, 1, &until, nullptr, FUTEX_BITSET_MATCH_ANY) != 0 &&
        errno != EAGAIN)
      break;
  }
  sleeps_.store(0, std::memory_order_relaxed);
  awake_since_.store(wall_clock(), std::memory_order_relaxed);
}

}  // namespace bip::rt
