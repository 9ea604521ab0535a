// Ctrl-C: see interrupt.hpp.
//
// The flag that the handler sets and the waker that it wakes are the only globals of the runtime: a signal handler can
// reach nothing else.
#include "runtime/engine/interrupt.hpp"

#include <atomic>
#include <csignal>

#include "runtime/engine/waker.hpp"

namespace bip::rt {

namespace {

volatile std::sig_atomic_t interrupted = 0;
std::atomic<Waker*> interrupt_wakes{nullptr};
extern "C" void bip_on_interrupt(int) {
  interrupted = 1;
  if (Waker* const waker = interrupt_wakes.load()) waker->wake();
}

}  // namespace

InterruptGuard::InterruptGuard(Waker* waker) {
  interrupted = 0;
  interrupt_wakes.store(waker);
  before_ = std::signal(SIGINT, bip_on_interrupt);
}
InterruptGuard::~InterruptGuard() {
  if (before_ != SIG_ERR) std::signal(SIGINT, before_);
  interrupt_wakes.store(nullptr);
}
bool is_interrupted() { return interrupted != 0; }

}  // namespace bip::rt
