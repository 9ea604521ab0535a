// When a proof must stop: the clock that limits are measured with, and the token that each question passes down to
// solvers, searches and invariant generators.
//
// A `CancellationSource` belongs to the asker of a question: the command line (Ctrl-C cancels its source), a language
// server (an edit cancels a proof of the text before it), a test. A `CancellationToken` refers to one source and has a
// deadline of its own, so that proofs in one process stop independently of each other. Nothing here is global.
//
// Time is the processor time of the whole process, all threads together: an answer within a limit does not depend on
// what else the machine does, and a limit that two threads share is used up in half the time. A person who waits may
// set a second deadline, of wall-clock time. Reading the clock is a
// system call: poll it now and then, not at every step.
#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <ctime>

namespace bip::verify {

/// Measures the seconds that the processor has worked for this process, on all threads together.
struct ProcessClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<ProcessClock>;
  static constexpr bool is_steady = true;
  /// Returns the processor time used so far. Cost: one system call.
  [[nodiscard]] static time_point now() {
    std::timespec spent{};
    (void)::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &spent);
    return time_point(std::chrono::seconds(spent.tv_sec) + std::chrono::nanoseconds(spent.tv_nsec));
  }
};

/// Owns the request to stop. It must outlive its tokens, therefore it neither moves nor copies.
class CancellationSource {
 public:
  CancellationSource() = default;
  CancellationSource(const CancellationSource&) = delete;
  CancellationSource& operator=(const CancellationSource&) = delete;

  /// Asks all holders of tokens to stop; they notice when they next poll. Any thread may call it, and a signal handler.
  void cancel() noexcept { is_cancelled_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool is_cancelled() const noexcept { return is_cancelled_.load(std::memory_order_relaxed); }

 private:
  static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");
  std::atomic<bool> is_cancelled_{false};
};

/// Says when to stop: if the source is cancelled, or when the deadline has passed. Without source it cannot be
/// cancelled, without deadline it has no end of its own. Copies are cheap and independent.
class CancellationToken {
 public:
  CancellationToken() = default;
  /// Refers to `source`, without deadline.
  explicit CancellationToken(const CancellationSource& source) : source_(&source) {}

  /// Returns a token of the same source that ends in `seconds` of processor time, or with this one if that is sooner.
  [[nodiscard]] CancellationToken within(double seconds) const {
    CancellationToken sooner = *this;
    if (seconds < kMaxSeconds)
      sooner.deadline_ =
          std::min(deadline_, ProcessClock::now() + std::chrono::duration_cast<ProcessClock::duration>(
                                                        std::chrono::duration<double>(std::max(seconds, 0.0))));
    return sooner;
  }

  /// Returns a token of the same source that ends in `seconds` of wall-clock time, or with this one if that is sooner.
  [[nodiscard]] CancellationToken within_wall_clock(double seconds) const {
    CancellationToken sooner = *this;
    if (seconds < kMaxSeconds)
      sooner.wall_deadline_ =
          std::min(wall_deadline_, WallClock::now() + std::chrono::duration_cast<WallClock::duration>(
                                                          std::chrono::duration<double>(std::max(seconds, 0.0))));
    return sooner;
  }

  /// Was the source cancelled? A passed deadline is no cancellation. Cost: one load.
  [[nodiscard]] bool is_cancelled() const noexcept { return source_ != nullptr && source_->is_cancelled(); }
  /// Must the holder stop: cancelled, or past the deadline? Cost: up to one system call.
  [[nodiscard]] bool is_over() const { return seconds_left() <= 0; }
  /// Returns the seconds of processor time to the deadline, at most `kMaxSeconds`; 0 if cancelled or past a deadline of
  /// wall-clock time, negative or 0 past the deadline.
  [[nodiscard]] double seconds_left() const {
    if (is_cancelled()) return 0;
    if (wall_deadline_ != WallClock::time_point::max() && WallClock::now() >= wall_deadline_) return 0;
    if (deadline_ == ProcessClock::time_point::max()) return kMaxSeconds;
    return std::chrono::duration<double>(deadline_ - ProcessClock::now()).count();
  }

 private:
  using WallClock = std::chrono::steady_clock;
  /// Three years: what is more counts as no deadline, and does not overflow the clock's nanoseconds.
  static constexpr double kMaxSeconds = 1e8;
  const CancellationSource* source_ = nullptr;
  ProcessClock::time_point deadline_ = ProcessClock::time_point::max();
  WallClock::time_point wall_deadline_ = WallClock::time_point::max();
};

/// Returns a token that cannot be cancelled and ends in `seconds` of processor time.
[[nodiscard]] inline CancellationToken within_seconds(double seconds) { return CancellationToken().within(seconds); }

}  // namespace bip::verify
