// A thread beside the engine's that notices when the engine stalls: a step that does not return within a bound, or
// steps that begin later than the bound allows. Then it says so, and calls the model's safe-stop function. It does so
// as well when the engine does not go on: a signal ends the process, the run has ended, the model is paused.
//
// It shares nothing with the engine but instants, so that no lock that a hanging function holds can hold it up. It
// looks eight times within the bound: the function is called after the bound and an eighth of it at the latest, if the
// system lets the thread run.
#pragma once
#include <semaphore.h>
#include <signal.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "bip/bip.hpp"

namespace bip::serve {

inline constexpr std::int64_t kLateByDefault = 100'000'000;

/// ns of the wall clock.
struct WatchOptions {
  std::int64_t stall = 0;   // 0: off
  std::int64_t late = 0;    // steps that begin so much later than they are due are reported; 0: none
  bool names_late = false;  // by what they do, and to clients as well
  /// Stops the robot; runs beside whatever hangs. May be empty.
  void (*safe_stop)(const char* why) = nullptr;
  std::string safe_stop_name;
  /// Asked on the engine's thread: where that thread notes which C++ function it is in. May be null.
  const std::atomic<const char*>* (*called_now)() = nullptr;
  /// Sets what the handler of signals that end the process calls, with the reason. May be null.
  void (*set_crash_hook)(void (*hook)(const char* why)) = nullptr;
  /// Sets what is called when the process of a module has died (bip/codel_processes.hpp). May be null.
  void (*set_module_hook)(void (*hook)(const char* why)) = nullptr;
};
/// What was noticed, in the words of a log.
struct Alarm {
  enum class Kind : std::uint8_t { Stalled, RunsAgain, Late, Stopped } kind = Kind::Stalled;
  std::int64_t ns = 0;  // of the wall clock: how long, how late
  std::string text;
  bool is_told = true;  // to clients; else it is for the log alone
};

class Watchdog {
 public:
  Watchdog(const Execution& system, const WatchOptions& options);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;
  /// Set before start(); called on the watchdog's thread, for Late on the engine's.
  std::function<void(const Alarm&)> on_alarm;
  void start();
  void halt();
  /// Any thread: the engine does not go on, so the safe-stop function is called, on the watchdog's thread.
  void stop_robot(std::string why);

  // ---- the engine's thread
  void enter_thread();
  void leave_thread();
  /// Before and after a step or a command, which may wait or work.
  void begin();
  void end() { begun_.store(0, std::memory_order_relaxed); }
  /// After a step.
  void note_step(const Step& step);
  /// Does it tell of steps by their names?
  [[nodiscard]] bool names_steps() const { return options_.late != 0 && options_.names_late; }

 private:
  void watch();
  void wait();
  void look();
  void do_asked_stops();
  static void on_crash(const char* why);
  static void on_module_death(const char* why);
  [[nodiscard]] std::int64_t busy_for(std::int64_t now) const;
  void alarm(Alarm::Kind kind, std::int64_t ns, std::string text);

  const Execution& system_;
  WatchOptions options_;
  std::atomic<std::int64_t> begun_{0};   // on the wall clock; 0: nothing is done
  std::atomic<std::int64_t> behind_{0};  // how late the last step began
  std::atomic<const std::atomic<const char*>*> called_{nullptr};
  std::int64_t last_late_ = -1;     // the instant of the last late step
  std::int64_t late_reported_ = 0;  // when the last report was, on the wall clock; 0: there was none
  std::int64_t late_instants_ = 0;  // since then
  std::int64_t stalled_since_ = 0;  // 0: it runs
  std::mutex lock_;
  std::vector<std::string> asked_stops_;  // why
  sem_t changed_{};  // of POSIX, for a handler may post it, and who waits for it does not spin first
  std::atomic<bool> quits_{false};
  std::thread thread_;
  std::unique_ptr<std::byte[]> signal_stack_;  // of the engine's thread
  stack_t stack_before_{};                     // what that thread had for its handlers
  // A crash: the handler waits on another thread until the function has returned.
  std::atomic<const char*> crash_why_{nullptr};
  std::atomic<bool> has_stopped_for_crash_{false};
};

}  // namespace bip::serve
