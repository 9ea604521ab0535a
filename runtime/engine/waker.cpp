// See waker.hpp.
#include "runtime/engine/waker.hpp"

#include <poll.h>
#include <sys/eventfd.h>
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

Waker::Waker() : file_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
Waker::~Waker() {
  if (file_ >= 0) ::close(file_);
}

void Waker::wake() noexcept {
  // Who posts for all he is worth finds nobody asleep, and writes to nothing that others read.
  if (!sleeps_.load(std::memory_order_seq_cst) || !sleeps_.exchange(false, std::memory_order_seq_cst)) return;
  const int before = errno;
  const std::uint64_t one = 1;
  // It fails only if it is full, and then the sleeper wakes anyway.
  [[maybe_unused]] const ssize_t written = ::write(file_, &one, sizeof one);
  errno = before;
}

void Waker::sleep_until(i64 instant) noexcept {
  pollfd waits{file_, POLLIN, 0};
  while (sleeps_.load(std::memory_order_seq_cst)) {
    const i64 left = std::min(instant == kForever ? kLongest : instant - wall_clock(), kLongest);
    if (left <= 0) break;
    const timespec length{static_cast<std::time_t>(left / kSecond), static_cast<long>(left % kSecond)};
    if (::ppoll(&waits, 1, &length, nullptr) != 0) break;
  }
  sleeps_.store(false, std::memory_order_relaxed);
  std::uint64_t count = 0;
  if ((waits.revents & POLLIN) != 0) {
    [[maybe_unused]] const ssize_t read = ::read(file_, &count, sizeof count);
  }
}

}  // namespace bip::rt
