// See watchdog.hpp.
#include "compiler/serve/watchdog.hpp"

#include <signal.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <exception>
#include <utility>

#include "bip/assert.hpp"

namespace bip::serve {

namespace {

std::int64_t steady_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::string milliseconds(std::int64_t ns) { return std::to_string(ns / 1'000'000) + " ms"; }

// Often enough to notice in time, not more often than a machine has clocks for.
std::int64_t look_after(std::int64_t stall) { return std::max<std::int64_t>(stall / 8, 1'000'000); }

// The one that a handler of signals asks.
std::atomic<Watchdog*> crash_watchdog{nullptr};
std::terminate_handler before_terminate = nullptr;
// What a safe-stop function may take while a signal ends the process.
constexpr int kLastStopMs = 1000;
constexpr std::int64_t kLateReportEvery = 1'000'000'000;

}  // namespace

Watchdog::Watchdog(const Execution& system, const WatchOptions& options) : system_(system), options_(options) {
  ::sem_init(&changed_, 0, 0);
}

Watchdog::~Watchdog() {
  halt();
  ::sem_destroy(&changed_);
}

void Watchdog::start() {
  if (options_.stall <= 0 && options_.safe_stop == nullptr) return;
  thread_ = std::thread([this] { watch(); });
  if (options_.safe_stop == nullptr || options_.set_crash_hook == nullptr) return;
  crash_watchdog.store(this);
  if (options_.set_module_hook != nullptr) options_.set_module_hook(&Watchdog::on_module_death);
  options_.set_crash_hook(&Watchdog::on_crash);
  static const bool is_set = [] {
    // An exception of another thread, and `std::exit` of the model's C++.
    before_terminate = std::set_terminate([] {
      on_crash("an exception ends the process");
      before_terminate();
    });
    return std::atexit([] { on_crash("the model's C++ ends the process"); }) == 0;
  }();
  (void)is_set;
}

void Watchdog::halt() {
  if (!thread_.joinable()) return;
  Watchdog* self = this;
  if (crash_watchdog.compare_exchange_strong(self, nullptr)) {
    options_.set_crash_hook(nullptr);
    if (options_.set_module_hook != nullptr) options_.set_module_hook(nullptr);
  }
  quits_ = true;
  ::sem_post(&changed_);
  thread_.join();
}

// In a handler, on the thread that has failed: calls only what a handler may call. The function itself runs on the
// watchdog's thread, which has a whole stack, and holds none of the locks that the failed thread may hold.
void Watchdog::on_crash(const char* why) {
  Watchdog* const watchdog = crash_watchdog.load();
  if (watchdog == nullptr || watchdog->thread_.get_id() == std::this_thread::get_id()) return;
  const char* none = nullptr;
  if (!watchdog->crash_why_.compare_exchange_strong(none, why)) return;
  ::sem_post(&watchdog->changed_);
  for (int k = 0; k < kLastStopMs && !watchdog->has_stopped_for_crash_; ++k) {
    const timespec moment{0, 1'000'000};
    ::nanosleep(&moment, nullptr);
  }
}

// On the thread that has noticed it, which goes on.
void Watchdog::on_module_death(const char* why) {
  if (Watchdog* const watchdog = crash_watchdog.load(); watchdog != nullptr) watchdog->stop_robot(why);
}

void Watchdog::stop_robot(std::string why) {
  if (options_.safe_stop == nullptr || !thread_.joinable()) return;
  {
    const std::lock_guard<std::mutex> hold(lock_);
    asked_stops_.push_back(std::move(why));
  }
  ::sem_post(&changed_);
}

// A thread whose stack is full needs another one for the handler.
void Watchdog::enter_thread() {
  BIP_ASSERT(signal_stack_ == nullptr, "the engine's thread is here already");
  if (options_.called_now != nullptr) called_.store(options_.called_now());
  if (options_.set_crash_hook == nullptr) return;
  constexpr std::size_t kSize = 1 << 16;
  signal_stack_ = std::make_unique<std::byte[]>(kSize);
  stack_t own{};
  own.ss_sp = signal_stack_.get();
  own.ss_size = kSize;
  if (::sigaltstack(&own, &stack_before_) != 0) signal_stack_.reset();
}

void Watchdog::leave_thread() {
  if (signal_stack_ == nullptr) return;
  (void)::sigaltstack(&stack_before_, nullptr);
  signal_stack_.reset();
}

void Watchdog::begin() {
  if (options_.stall > 0) begun_.store(steady_ns(), std::memory_order_relaxed);
}

// Since the step began or the engine woke up, whichever was later; what sleeps is not busy.
std::int64_t Watchdog::busy_for(std::int64_t now) const {
  const std::int64_t begun = begun_.load(std::memory_order_relaxed), awake = system_.awake_since();
  return begun == 0 || awake == 0 ? 0 : now - std::max(begun, awake);
}

void Watchdog::alarm(Alarm::Kind kind, std::int64_t ns, std::string text) {
  if (on_alarm) on_alarm({kind, ns, std::move(text)});
}

void Watchdog::do_asked_stops() {
  if (const char* const why = crash_why_.load(); why != nullptr && !has_stopped_for_crash_) {
    options_.safe_stop(why);
    has_stopped_for_crash_ = true;
  }
  std::vector<std::string> asked;
  {
    const std::lock_guard<std::mutex> hold(lock_);
    asked.swap(asked_stops_);
  }
  BIP_ASSERT(asked.empty() || options_.safe_stop != nullptr, "{} stops are asked for, and nothing stops", asked.size());
  for (const std::string& why : asked) {
    options_.safe_stop(why.c_str());
    alarm(Alarm::Kind::Stopped, 0, why + ": `" + options_.safe_stop_name + "` was called");
  }
}

void Watchdog::watch() {
  while (!quits_) {
    wait();
    do_asked_stops();
    if (options_.stall > 0 && !quits_) look();
  }
  do_asked_stops();
}

// Until there is something to do, or it is time to look; a signal may end it earlier, which does no harm.
void Watchdog::wait() {
  if (options_.stall <= 0) {
    ::sem_wait(&changed_);
    return;
  }
  const std::int64_t until = steady_ns() + look_after(options_.stall);
  const timespec instant{static_cast<time_t>(until / 1'000'000'000), static_cast<long>(until % 1'000'000'000)};
  ::sem_clockwait(&changed_, CLOCK_MONOTONIC, &instant);
}

void Watchdog::look() {
  BIP_ASSERT(options_.stall > 0, "a watch for {} ns", options_.stall);
  const std::int64_t now = steady_ns(), busy = busy_for(now);
  // What sleeps has caught up.
  const std::int64_t behind = busy == 0 ? 0 : behind_.load(std::memory_order_relaxed);
  const bool stalls = busy > options_.stall || behind > options_.stall;
  if (!stalls && stalled_since_ != 0) {
    alarm(Alarm::Kind::RunsAgain, now - stalled_since_,
          "the engine runs again, " + milliseconds(now - stalled_since_) + " after it stalled");
    stalled_since_ = 0;
  }
  if (!stalls || stalled_since_ != 0) return;
  stalled_since_ = now - std::max(busy, behind);
  const auto* const called = called_.load();
  const char* const function = called == nullptr ? nullptr : called->load(std::memory_order_relaxed);
  std::string why = busy > options_.stall ? "no step has returned for " + milliseconds(busy)
                                          : "steps begin " + milliseconds(behind) + " too late";
  if (busy > options_.stall && function != nullptr) why += ", the model is in " + std::string(function);
  // First the robot, then the log: writing may wait.
  if (options_.safe_stop != nullptr) {
    options_.safe_stop(why.c_str());
    why += ": `" + options_.safe_stop_name + "` was called";
  }
  alarm(Alarm::Kind::Stalled, std::max(busy, behind), std::move(why));
}

void Watchdog::note_step(const Step& step) {
  if (options_.stall == 0 && options_.late == 0) return;
  const std::int64_t late = system_.lateness();
  behind_.store(late, std::memory_order_relaxed);
  // All steps of an instant are late if the first one is.
  if (options_.late == 0 || late <= options_.late || last_late_ == system_.now()) return;
  last_late_ = system_.now();
  ++late_instants_;
  // A machine that is too slow would fill its log.
  const std::int64_t now = steady_ns();
  if (late_reported_ != 0 && now - late_reported_ < kLateReportEvery) return;
  late_reported_ = now;
  const std::int64_t others = std::exchange(late_instants_, 0) - 1;
  std::string text = "step " + std::to_string(step.number);
  if (names_steps()) text += ", `" + step.interaction + "`,";
  text += " begins " + milliseconds(late) + " too late";
  if (others > 0) text += ", and steps of " + std::to_string(others) + " instants before it did so";
  if (on_alarm) on_alarm({Alarm::Kind::Late, late, std::move(text), names_steps()});
}

}  // namespace bip::serve
