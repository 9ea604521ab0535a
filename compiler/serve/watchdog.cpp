// See watchdog.hpp.
#include "compiler/serve/watchdog.hpp"

#include <algorithm>
#include <chrono>

namespace bip::serve {

namespace {

std::int64_t steady_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::string milliseconds(std::int64_t ns) { return std::to_string(ns / 1'000'000) + " ms"; }

// Often enough to notice in time, not more often than a machine has clocks for.
std::chrono::nanoseconds look_after(std::int64_t stall) {
  return std::chrono::nanoseconds(std::max<std::int64_t>(stall / 8, 1'000'000));
}

}  // namespace

void Watchdog::start() {
  if (options_.stall > 0) thread_ = std::thread([this] { watch(); });
}

void Watchdog::halt() {
  {
    const std::lock_guard<std::mutex> hold(lock_);
    quits_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
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

void Watchdog::watch() {
  std::int64_t stalled_since = 0;  // 0: it runs
  std::unique_lock<std::mutex> hold(lock_);
  while (!changed_.wait_for(hold, look_after(options_.stall), [this] { return quits_; })) {
    const std::int64_t now = steady_ns(), busy = busy_for(now);
    // What sleeps has caught up.
    const std::int64_t behind = busy == 0 ? 0 : behind_.load(std::memory_order_relaxed);
    const bool stalls = busy > options_.stall || behind > options_.stall;
    if (!stalls && stalled_since != 0) {
      alarm(Alarm::Kind::RunsAgain, now - stalled_since,
            "the engine runs again, " + milliseconds(now - stalled_since) + " after it stalled");
      stalled_since = 0;
    }
    if (!stalls || stalled_since != 0) continue;
    stalled_since = now - std::max(busy, behind);
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
}

void Watchdog::note_step(const Step& step) {
  if (options_.stall == 0 && options_.late == 0) return;
  const std::int64_t late = system_.lateness();
  behind_.store(late, std::memory_order_relaxed);
  // All steps of an instant are late if the first one is.
  if (options_.late == 0 || late <= options_.late || last_late_ == system_.now()) return;
  last_late_ = system_.now();
  alarm(Alarm::Kind::Late, late,
        "step " + std::to_string(step.number) + ", `" + step.interaction + "`, begins " + milliseconds(late) +
            " too late");
}

}  // namespace bip::serve
