// What emitted code and the shared object of `bipc run` need around calls of C++: faults from exceptions, variables
// that are C++ objects. Not part of emitted programs that call nothing.
#pragma once
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <exception>

#include "bip/emitted.hpp"
#include "bip/ffi.hpp"

namespace bip::rt {

/// The C++ function that a thread is in, named when a signal ends the process. A literal, or null.
inline thread_local std::atomic<const char*> called_now{nullptr};
/// The line of the model that calls it. Of the thread's FfiContext, or null.
inline thread_local std::atomic<const char*> called_at{nullptr};
class CallNote {
 public:
  CallNote(const char* what, const char* where)
      : what_before_(called_now.load(std::memory_order_relaxed)),
        where_before_(called_at.load(std::memory_order_relaxed)) {
    called_now.store(what, std::memory_order_relaxed);
    called_at.store(where, std::memory_order_relaxed);
  }
  CallNote(const CallNote&) = delete;
  CallNote& operator=(const CallNote&) = delete;
  ~CallNote() {
    called_now.store(what_before_, std::memory_order_relaxed);
    called_at.store(where_before_, std::memory_order_relaxed);
  }

 private:
  const char *what_before_, *where_before_;
};

/// The value of a clock, for an `int` parameter: towards 0, and no further than an `int` goes.
inline std::int32_t whole_units(double value) {
  if (value >= 2147483647.0) return 2147483647;
  return value <= -2147483648.0 ? -2147483647 - 1 : static_cast<std::int32_t>(value);
}

namespace crash {

/// Called before a signal ends the process, in the handler. May be null.
inline std::atomic<void (*)(const char* why)> hook{nullptr};
/// Why: a text that lasts.
inline char reason[512];

inline void say(const char* text) {
  // A failure cannot be reported anywhere.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, std::strlen(text));
}
// Calls only what a signal handler may call.
inline void handle(int signal) {
  const char* name = signal == SIGSEGV   ? "SIGSEGV (a bad address, or the stack is full)"
                     : signal == SIGFPE  ? "SIGFPE (a division)"
                     : signal == SIGBUS  ? "SIGBUS"
                     : signal == SIGABRT ? "SIGABRT (abort)"
                                         : "SIGILL";
  const char* const what = called_now.load(std::memory_order_relaxed);
  const char* where = called_at.load(std::memory_order_relaxed);
  if (where == nullptr) where = "";
  const char* const calls = *where == '\0' ? "" : ", called at ";
  if (what != nullptr) {
    for (const char* part : {"\nerror: signal ", name, " in the model's C++, ", what, calls, where, "\n"}) say(part);
  }
  if (void (*const stop)(const char*) = hook.exchange(nullptr); stop != nullptr) {
    std::size_t size = 0;
    for (const char* part :
         {"signal ", name, what == nullptr ? "" : " in ", what == nullptr ? "" : what, calls, where}) {
      for (; *part != '\0' && size + 1 < sizeof reason; ++part) reason[size++] = *part;
    }
    stop(reason);
  }
  // SA_RESETHAND removed the handler: now the signal ends the process.
  ::raise(signal);
}

}  // namespace crash

/// From now on a signal that ends the process says in which C++ function of the model that was.
inline bool name_crashes() {
  alignas(16) static char stack[1 << 16];
  stack_t own{};
  if (::sigaltstack(nullptr, &own) == 0 && (own.ss_flags & SS_DISABLE) != 0) {
    own = {};
    own.ss_sp = stack;
    own.ss_size = sizeof stack;
    (void)::sigaltstack(&own, nullptr);
  }
  struct sigaction action {};
  action.sa_handler = crash::handle;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER | SA_ONSTACK);
  for (const int signal : {SIGSEGV, SIGFPE, SIGBUS, SIGABRT, SIGILL}) {
    struct sigaction before {};
    // A handler that is there stays: a sanitizer's, an embedding program's.
    if (::sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_DFL)
      (void)::sigaction(signal, &action, nullptr);
  }
  return true;
}

/// In a handler: the exception becomes the fault of the call at `site`.
[[noreturn]] inline void raise(FfiContext& ffi, std::uint32_t site) {
  try {
    throw;
  } catch (const std::exception& exception) {
    ffi.set_message(exception.what());
  } catch (...) {
    ffi.set_message("");
  }
  throw CodeFault{fault_status(site, FaultKind{})};
}

/// A variable of an FFI type. Assignment copies the object.
template <class T>
class FfiVariable {
 public:
  explicit FfiVariable(const Cell& cell) : object_(object_in<T>(cell)) {}
  FfiVariable(const FfiVariable&) = delete;
  FfiVariable& operator=(const T& value) {
    object_ = value;
    return *this;
  }
  FfiVariable& operator=(const FfiVariable& other) { return *this = other.object_; }
  operator T&() const { return object_; }

 private:
  T& object_;
};

}  // namespace bip::rt
