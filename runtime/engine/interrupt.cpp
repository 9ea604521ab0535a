// Signals that end a run: see interrupt.hpp.
//
// The flag that the handler sets and the waker that it wakes are the only globals of the runtime: a signal handler can
// reach nothing else.
#include "runtime/engine/interrupt.hpp"

#include <atomic>
#include <csignal>

#include "bip/assert.hpp"
#include "runtime/engine/waker.hpp"

namespace bip::rt {

namespace {

volatile std::sig_atomic_t interrupted = 0;  // the signal's number
std::atomic<Waker*> interrupt_wakes{nullptr};
extern "C" void bip_on_interrupt(int signal) {
  interrupted = signal;
  if (Waker* const waker = interrupt_wakes.load()) waker->wake();
}

// The flag is cleared before the handler is there.
void (*begin_interrupts(Waker* waker))(int) {
  interrupted = 0;
  interrupt_wakes.store(waker);
  return bip_on_interrupt;
}

}  // namespace

EndingSignals::EndingSignals(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  ::sigemptyset(&action.sa_mask);
  for (std::size_t k = 0; k < kEndingSignals.size(); ++k) {
    ::sigaction(kEndingSignals[k], nullptr, &before_[k]);
    if (kEndingSignals[k] != SIGINT && before_[k].sa_handler == SIG_IGN) continue;
    ::sigaction(kEndingSignals[k], &action, nullptr);
  }
}

EndingSignals::~EndingSignals() {
  for (std::size_t k = 0; k < kEndingSignals.size(); ++k) ::sigaction(kEndingSignals[k], &before_[k], nullptr);
}

InterruptGuard::InterruptGuard(Waker* waker) : signals_(begin_interrupts(waker)) {}
InterruptGuard::~InterruptGuard() { interrupt_wakes.store(nullptr); }

bool is_interrupted() { return interrupted != 0; }
int interrupting_signal() {
  BIP_ASSERT(is_interrupted(), "no signal came");
  return interrupted;
}

}  // namespace bip::rt
