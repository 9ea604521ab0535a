// The threaded engine: see threads.hpp.
#include "runtime/engine/threads.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "bip/assert.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/start_thread.hpp"
#include "runtime/engine/collect_strings.hpp"
#include "runtime/engine/flights.hpp"
#include "runtime/engine/interrupt.hpp"

namespace bip::rt {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::int64_t kShort = 3000;     // ns: handing an action over costs about as much
constexpr std::uint32_t kTrials = 3;      // times that an action is handed over before it is judged
constexpr std::uint32_t kLookAgain = 64;  // a short one is timed again every so often

// What actions of one transition have cost, in ns.
struct Cost {
  std::int64_t mean = 0;
  std::uint32_t runs = 0;
  [[nodiscard]] bool is_short() const { return runs >= kTrials && mean < kShort; }
  void add(std::int64_t ns) {
    mean = runs == 0 ? ns : mean + (ns - mean) / 4;
    ++runs;
  }
};

class ThreadedRun {
 public:
  ThreadedRun(Core& core, Scheduler& scheduler, const RunOptions& options, Output& output)
      : core_(core),
        scheduler_(scheduler),
        options_(options),
        output_(output),
        writes_(output.writes_steps()),
        costs_(core.tables().transitions.size()) {}

  ThreadedResult run() {
    core_.partial().allow();
    ThreadedResult result;
    result.threads = options_.threads != 0 ? options_.threads : std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::thread> others;
    for (u32 k = 1; k < result.threads; ++k) {
      if (!start_thread(others, [this, k] { work(k); })) result.threads = k;
    }
    work(0);
    for (std::thread& thread : others) thread.join();
    const PartialState& partial = *core_.partial().state();
    result.most_busy = partial.most_busy;
    result.handed_over = handed_over_;
    result.steps = steps_;
    const u64 fault_step = partial.fault_step;
    BIP_ASSERT(partial.busy == 0 && ready_.empty(), "{} atoms at work after the end", partial.busy);
    BIP_ASSERT(steps_ <= options_.limit, "{} steps of {}", steps_, options_.limit);
    if (!core_.partial().end()) {
      result.end = End::Fault;
      result.steps = fault_step;
      // The step that ends in a fault is in the trace, as in any run.
      if (writes_) flights_.write_until(fault_step);
    } else if (steps_ == options_.limit) {
      result.end = End::Limit;
    } else {
      result.end = core_.candidate_count() != 0 ? End::Interrupted : end_without_step(core_);
    }
    return result;
  }

 private:
  void landed(u64 step) {
    if (!writes_) return;
    flights_.land(step);
    if (!stopping_) flights_.write_landed();
  }

  bool start() {
    // Atoms at work have strings that no cell refers to.
    if (core_.partial().state()->busy == 0) collect_strings(core_);
    EnabledSet::Position at{};
    if (stopping_ || steps_ == options_.limit || is_interrupted() || !scheduler_.choose_decided(core_, at))
      return false;
    fresh_.clear();
    if (writes_) flights_.depart(core_, at);
    scheduler_.fired(at.interaction);
    BIP_ASSERT(!writes_ || flights_.departed() == steps_ + 1, "{} steps departed of {}", flights_.departed(),
               steps_ + 1);
    if (!core_.partial().begin(at, steps_, fresh_)) stopping_ = true;
    if (writes_) {
      flights_.set_parts(static_cast<u32>(fresh_.size()) + 1);
      landed(steps_);
    }
    ++steps_;
    for (const Work& work : fresh_) run_or_queue(work);
    return true;
  }

  [[nodiscard]] Cost& cost_of(const Work& work) {
    BIP_ASSERT(static_cast<std::size_t>(work.transition - core_.tables().transitions.data()) < costs_.size(),
               "a transition of another image");
    return costs_[static_cast<std::size_t>(work.transition - core_.tables().transitions.data())];
  }

  // Taken under the lock if that is shorter; otherwise the thread queues the work for itself.
  void run_or_queue(Work work) {
    std::int32_t status = 1;
    do {
      if (work.transition->action.fn == nullptr) {
        status = 1;
        continue;
      }
      Cost& cost = cost_of(work);
      if (options_.perturb != 0 || !cost.is_short()) {
        ready_.push_back(work);
        return;
      }
      if (++cost.runs % kLookAgain == 0) {
        const auto start = Clock::now();
        status = core_.partial().run(work);
        cost.add((Clock::now() - start).count());
      } else {
        status = core_.partial().run(work);
      }
    } while (!ended(work, status));
  }

  // False: the work goes on with an internal transition.
  bool ended(Work& work, std::int32_t status) {
    const Finished how = core_.partial().finish(work, status);
    if (how == Finished::More) return false;
    if (how == Finished::Fault) stopping_ = true;
    landed(work.step);
    return true;
  }

  void work(u32 self) {
    Prng delays(options_.perturb + self);
    std::unique_lock guard(lock_);
    for (;;) {
      if (ready_.empty() && start()) continue;
      if (!ready_.empty()) {
        Work next = ready_.front();
        ready_.pop_front();
        if (waiting_ != 0) wake_.notify_one();
        run_outside(guard, next, delays);
        continue;
      }
      if (core_.partial().state()->busy == 0) {
        wake_.notify_all();
        return;
      }
      ++waiting_;
      wake_.wait(guard);
      --waiting_;
    }
  }

  void run_outside(std::unique_lock<std::mutex>& guard, Work& work, Prng& delays) {
    std::int32_t status = 0;
    do {
      ++handed_over_;
      guard.unlock();
      perturb(delays);
      const auto start = Clock::now();
      status = core_.partial().run(work);
      const std::int64_t ns = (Clock::now() - start).count();
      perturb(delays);
      guard.lock();
      cost_of(work).add(ns);
    } while (!ended(work, status));
    if (waiting_ != 0) wake_.notify_one();
  }

  void perturb(Prng& delays) const {
    if (options_.perturb == 0) return;
    const u64 how = delays.below(16);
    if (how == 0) std::this_thread::sleep_for(std::chrono::microseconds(delays.below(50)));
    for (u64 n = how % 4; n > 0; --n) std::this_thread::yield();
  }

  Core& core_;
  Scheduler& scheduler_;
  const RunOptions& options_;
  Output& output_;
  bool writes_;
  std::mutex lock_;
  std::condition_variable wake_;
  // All of the rest only under the lock.
  std::vector<Cost> costs_;  // by transition
  std::deque<Work> ready_;
  std::vector<Work> fresh_;
  Flights flights_{output_};
  u64 steps_ = 0, handed_over_ = 0;
  u32 waiting_ = 0;
  bool stopping_ = false;  // a fault was met
};

}  // namespace

ThreadedResult run_threads(Core& core, Scheduler& scheduler, const RunOptions& options, Output& output) {
  return ThreadedRun(core, scheduler, options, output).run();
}

}  // namespace bip::rt
