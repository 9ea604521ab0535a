// Signals that ask a program to end while an engine works: a flag instead of the end of the process, so that what is
// known can be told and what was begun can be finished.
#pragma once
#include <array>
#include <csignal>

namespace bip::rt {

class Waker;

/// Ctrl-C, `kill`, and the end of the terminal: all end a run in the same way.
inline constexpr std::array kEndingSignals{SIGINT, SIGTERM, SIGHUP};

/// Handles the signals of kEndingSignals by `handler` while it lives; then puts back what was there before. SIGHUP and
/// SIGTERM stay ignored if they were (nohup).
class EndingSignals {
 public:
  explicit EndingSignals(void (*handler)(int));
  ~EndingSignals();
  EndingSignals(const EndingSignals&) = delete;
  EndingSignals& operator=(const EndingSignals&) = delete;

 private:
  std::array<struct sigaction, kEndingSignals.size()> before_{};
};

/// While it lives each of the signals sets the flag and wakes `waker`.
class InterruptGuard {
 public:
  explicit InterruptGuard(Waker* waker = nullptr);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  EndingSignals signals_;
};

[[nodiscard]] bool is_interrupted();
/// The signal that set the flag. Requires is_interrupted().
[[nodiscard]] int interrupting_signal();

}  // namespace bip::rt
