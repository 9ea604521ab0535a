// Ctrl-C while an engine works: a flag instead of the end of the process, so that what is known can be told.
#pragma once
#include <csignal>

namespace bip::rt {

class Waker;

/// While it lives SIGINT sets the flag and wakes `waker`; the handler that was there before is put back afterwards.
class InterruptGuard {
 public:
  explicit InterruptGuard(Waker* waker = nullptr);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  void (*before_)(int);
};

[[nodiscard]] bool is_interrupted();

}  // namespace bip::rt
