// See delay_signals.hpp.
//
// A handler is process-wide, and others may save it as the one that they restore later. So it also works when no object
// lives any more: then it ends the process as the default would have done.
#include "compiler/base/delay_signals.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <mutex>

#include "runtime/include/bip/assert.hpp"

namespace bip {

namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

std::atomic<int> alive{0};
std::atomic<int> delayed_signal{0};
std::mutex changes;

void end_by(int signal) {
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

extern "C" void bip_delay_signal(int signal) {
  delayed_signal.store(signal);
  // The signal is blocked until this handler returns, and ends the process then.
  if (alive.load() == 0) end_by(signal);
}

// Replaces the handler `from` of each signal that has it.
void replace_handlers(void (*from)(int), void (*to)(int)) {
  for (const int signal : kSignals) {
    struct sigaction action {};
    if (::sigaction(signal, nullptr, &action) != 0 || (action.sa_flags & SA_SIGINFO) != 0 || action.sa_handler != from)
      continue;
    action = {};
    action.sa_handler = to;
    action.sa_flags = SA_RESTART;
    ::sigemptyset(&action.sa_mask);
    ::sigaction(signal, &action, nullptr);
  }
}

}  // namespace

DelayedSignals::DelayedSignals() {
  const std::lock_guard<std::mutex> hold(changes);
  if (alive.fetch_add(1) == 0) replace_handlers(SIG_DFL, bip_delay_signal);
}

DelayedSignals::~DelayedSignals() {
  const std::lock_guard<std::mutex> hold(changes);
  BIP_ASSERT(alive.load() > 0, "signals are delayed by {} objects", alive.load());
  if (alive.fetch_sub(1) != 1) return;
  replace_handlers(bip_delay_signal, SIG_DFL);
  if (const int signal = delayed_signal.exchange(0); signal != 0) end_by(signal);
}

}  // namespace bip
