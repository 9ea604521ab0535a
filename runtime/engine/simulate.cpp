// See simulate.hpp. A thread has a core of its own, which goes back to the initial state before each run.
#include "runtime/engine/simulate.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <thread>

#include "bip/assert.hpp"
#include "bip/ffi.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/start_thread.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/collect_strings.hpp"
#include "runtime/engine/timed_scheduler.hpp"

namespace bip::rt {
namespace {

constexpr std::uint64_t kRunsPerPiece = 16;
constexpr std::uint64_t kStepsPerPiece = 1 << 20;
constexpr double kNanoseconds = 1e9;
constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

bool must_stop(const SimulateOptions& options) {
  return is_interrupted() || (options.is_stopped && options.is_stopped());
}

/// What one observer has seen of the run that is under way.
struct Seen {
  double value = 0;  // of the last state
  double result = kUndefined, weight = 0;
};

/// Makes runs, one after the other.
class Simulator {
 public:
  Simulator(const Image& image, const SimulateOptions& options, SimulateReport& report)
      : options_(options),
        report_(report),
        core_(image, {.progress = options.progress}),
        feed_(core_),
        scheduler_(options.policy, options.asap, options.seed),
        seen_(options.observers.size()) {
    is_seeding_cpp_ = image.ffi != nullptr;
    if (is_seeding_cpp_) std::srand(static_cast<unsigned>(options.seed));
    has_draws_ = has_draws(image);
    core_.seed_draws(options.seed);
    scheduler_.prepare(core_);
    is_sound_ = core_.initialize();
    if (is_sound_) {
      scheduler_.start(core_);
      initial_ = core_.snapshot();
      order_ = core_.enabled().list_order();
    } else if (!has_draws_) {  // what a model draws may differ in the next run
      return;
    }
    pin_strings(core_);
    counts_ = std::any_of(options.observers.begin(), options.observers.end(),
                          [](const Observer& o) { return o.kind == ObserverKind::Count; });
    const bool watches_steps = std::any_of(options.observers.begin(), options.observers.end(),
                                           [](const Observer& o) { return o.kind != ObserverKind::Last; });
    is_compiled_ = !watches_steps && !options.stop && options.queries.empty() && options.policy == Policy::Uniform &&
                   !core_.is_timed() && core_.steps().has_steps();
  }

  /// False: interrupted, and the run counts for nothing.
  bool run(std::uint64_t number) {
    const std::uint64_t seed = options_.seed + number;
    std::uint64_t steps = 0;
    SimulatedEnd end = SimulatedEnd::Fault;
    if (begin(seed)) end = go(steps);
    if (end == SimulatedEnd::NotRun) return false;
    for (std::size_t k = 0; k < answers_.size(); ++k) report_.answers[k][number] = answer_of(k, end);
    if (end != SimulatedEnd::Fault) observe_end();
    report_.ends[number] = end;
    report_.steps[number] = steps;
    if (!report_.times.empty()) report_.times[number] = now();
    for (std::size_t k = 0; k < seen_.size(); ++k) report_.values[k][number] = result_of(k);
    return true;
  }
  /// The last run's, which ended in a fault.
  [[nodiscard]] std::string fault(std::uint64_t number) const {
    return fault_text(core_, options_.seed + number, report_.steps[number]);
  }

 private:
  [[nodiscard]] double now() const {
    return core_.is_timed() ? static_cast<double>(core_.now()) / kNanoseconds : static_cast<double>(steps_);
  }

  // To the initial state. False: it ends in a fault.
  bool begin(std::uint64_t seed) {
    steps_ = 0;
    if (is_seeding_cpp_) std::srand(static_cast<unsigned>(seed));
    scheduler_ = TimedScheduler(options_.policy, options_.asap, seed);
    scheduler_.prepare(core_);
    if (has_draws_) {
      core_.seed_draws(seed);
      is_sound_ = core_.initialize();
    }
    if (!is_sound_) return false;
    if (has_draws_) {
      scheduler_.start(core_);
    } else {
      if (!core_.restore(initial_)) return false;
      // What an `initial` waits for is drawn anew.
      if (core_.time().draws_resumes() && core_.time().has_initial_resume() && !core_.initialize()) return false;
      core_.set_list_order(order_);
    }
    answers_.assign(options_.queries.size(), Answer::Open);
    since_ = now();
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      const Observer& observer = options_.observers[k];
      Seen& seen = seen_[k];
      seen = {};
      const bool is_sum = observer.kind == ObserverKind::Count || observer.kind == ObserverKind::Duration ||
                          observer.kind == ObserverKind::Reaches;
      if (is_sum) seen.result = 0;
      if (observer.value && observer.kind != ObserverKind::Last) look(observer, seen);
    }
    return true;
  }

  // Steps until the run ends. NotRun: interrupted.
  SimulatedEnd go(std::uint64_t& steps) {
    if (is_compiled_) return go_compiled(steps);
    while (true) {
      if (!answers_.empty() && answer() && options_.observers.empty()) return SimulatedEnd::Answered;
      if (options_.stop && options_.stop(core_)) return SimulatedEnd::Stop;
      if (steps >= options_.limit) return SimulatedEnd::Limit;
      if ((steps & 1023u) == 0 && must_stop(options_)) return SimulatedEnd::NotRun;
      switch (scheduler_.wait(core_, feed_)) {
        case Due::Event: continue;
        case Due::Stopped: return SimulatedEnd::NotRun;
        case Due::Deadlock: return end_without_candidates();
        case Due::Fault: return SimulatedEnd::Fault;
        case Due::Step: break;
      }
      if (core_.now() >= options_.until) return SimulatedEnd::Time;
      const EnabledSet::Position at = scheduler_.choice();
      count(at);
      if (!(core_.is_timed() ? core_.time().take(at) : core_.take(at))) return SimulatedEnd::Fault;
      scheduler_.fired(at.interaction);
      collect_strings(core_);
      steps_ = ++steps;
      observe();
    }
  }
  SimulatedEnd go_compiled(std::uint64_t& steps) {
    bool is_sound = true;
    while (steps < options_.limit) {
      const std::uint64_t wanted = steps_before_collection(core_, std::min(options_.limit - steps, kStepsPerPiece));
      const std::uint64_t taken = scheduler_.untimed().run_steps(
          core_, wanted, [] { return is_interrupted(); }, is_sound);
      steps_ = steps += taken;
      if (!is_sound) return SimulatedEnd::Fault;
      collect_strings(core_);
      if (must_stop(options_)) return SimulatedEnd::NotRun;
      if (taken < wanted) return end_without_candidates();
    }
    return SimulatedEnd::Limit;
  }
  [[nodiscard]] SimulatedEnd end_without_candidates() const {
    return is_final_state(core_) ? SimulatedEnd::Final : SimulatedEnd::Deadlock;
  }

  // In the state that was just entered. True: all queries are answered.
  bool answer() {
    bool is_open = false;
    for (std::size_t k = 0; k < answers_.size(); ++k) {
      if (answers_[k] == Answer::Open) answers_[k] = answer_in(options_.queries[k], core_, steps_);
      is_open |= answers_[k] == Answer::Open;
    }
    return !is_open;
  }
  // At an end without further steps nothing changes any more; at `until` a bound may have passed.
  [[nodiscard]] Answer answer_of(std::size_t k, SimulatedEnd end) const {
    const PathQuery& query = options_.queries[k];
    if (answers_[k] != Answer::Open) return answers_[k];
    const bool is_over = end == SimulatedEnd::Deadlock || end == SimulatedEnd::Final ||
                         (end == SimulatedEnd::Time && query.until < options_.until);
    return is_over ? answer_at_end(query) : Answer::Open;
  }

  // Before the step is taken.
  void count(EnabledSet::Position at) {
    if (!counts_) return;
    const Candidate candidate = core_.candidate(at);
    bool has_participants = false;
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      const Observer& observer = options_.observers[k];
      if (observer.kind != ObserverKind::Count) continue;
      bool is_meant = candidate.connector == observer.connector && observer.connector != kNone;
      if (observer.atom != kNone) {
        if (!has_participants) core_.participants(candidate, participants_);
        has_participants = true;
        is_meant = std::any_of(participants_.begin(), participants_.end(), [&](const Participant& p) {
          return p.atom == observer.atom && p.port == observer.port;
        });
      }
      if (is_meant) seen_[k].result += 1;
    }
  }

  // After a step: what held until now, and what holds now.
  void observe() {
    const double instant = now();
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      const Observer& observer = options_.observers[k];
      if (observer.kind == ObserverKind::Count || observer.kind == ObserverKind::Last) continue;
      pass(observer, seen_[k], instant - since_);
      look(observer, seen_[k]);
    }
    since_ = instant;
  }
  // Time that passed with the last value.
  static void pass(const Observer& observer, Seen& seen, double duration) {
    if (observer.kind == ObserverKind::Duration && seen.value != 0) seen.result += duration;
    if (observer.kind == ObserverKind::Mean && duration > 0) {
      seen.weight += duration;
      seen.result += (seen.value - seen.result) * (duration / seen.weight);
    }
  }
  void look(const Observer& observer, Seen& seen) const {
    if (observer.kind == ObserverKind::Reaches && seen.result != 0) return;
    if (observer.kind == ObserverKind::Time && !std::isnan(seen.result)) return;
    seen.value = observer.value(core_);
    switch (observer.kind) {
      case ObserverKind::Reaches: seen.result = seen.value != 0 ? 1 : 0; break;
      case ObserverKind::Time:
        if (seen.value != 0) seen.result = now();
        break;
      case ObserverKind::Max: seen.result = std::fmax(seen.result, seen.value); break;
      case ObserverKind::Min: seen.result = std::fmin(seen.result, seen.value); break;
      case ObserverKind::Mean:
        if (std::isnan(seen.result)) seen.result = seen.value;
        break;
      case ObserverKind::Count:
      case ObserverKind::Duration:
      case ObserverKind::Last: break;
    }
  }
  // At `until` time has passed without a step.
  void observe_end() {
    const double instant =
        core_.is_timed() ? static_cast<double>(std::min(core_.now(), options_.until)) / kNanoseconds : now();
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      const Observer& observer = options_.observers[k];
      if (observer.kind == ObserverKind::Last) seen_[k].result = observer.value(core_);
      else if (observer.kind != ObserverKind::Count) pass(observer, seen_[k], instant - since_);
    }
  }
  [[nodiscard]] double result_of(std::size_t k) const { return is_sound_ ? seen_[k].result : kUndefined; }

  const SimulateOptions& options_;
  SimulateReport& report_;
  Core core_;
  EventFeed feed_;
  TimedScheduler scheduler_;
  State initial_;
  std::vector<InteractionId> order_;
  std::vector<Seen> seen_;       // by observer
  std::vector<Answer> answers_;  // by query
  std::vector<Participant> participants_;
  std::uint64_t steps_ = 0;
  double since_ = 0;  // the instant of the state that was looked at last
  bool has_draws_ = false, is_sound_ = false, is_compiled_ = false, is_seeding_cpp_ = false, counts_ = false;
};

}  // namespace

const char* name_of(SimulatedEnd end) {
  switch (end) {
    case SimulatedEnd::Limit: return "limit";
    case SimulatedEnd::Deadlock: return "deadlock";
    case SimulatedEnd::Fault: return "error";
    case SimulatedEnd::Final: return "final";
    case SimulatedEnd::Time: return "time";
    case SimulatedEnd::Stop: return "stop";
    case SimulatedEnd::Answered: return "answered";
    case SimulatedEnd::NotRun: return "not run";
  }
  return "";
}

SimulateReport simulate(const Image& image, const SimulateOptions& options) {
  SimulateReport report;
  report.ends.assign(options.runs, SimulatedEnd::NotRun);
  report.steps.assign(options.runs, 0);
  if (has_time(image)) report.times.assign(options.runs, 0);
  report.answers.assign(options.queries.size(), std::vector<Answer>(options.runs, Answer::Open));
  report.values.assign(options.observers.size(), std::vector<double>(options.runs, kUndefined));
  std::atomic<std::uint64_t> next{0}, done{0};
  std::mutex lock;
  std::uint64_t first_fault = ~std::uint64_t{0};
  const auto work = [&](bool tells) {
    Simulator simulator(image, options, report);
    while (true) {
      const std::uint64_t from = next.fetch_add(kRunsPerPiece);
      if (from >= options.runs) return;
      const std::uint64_t to = std::min(from + kRunsPerPiece, options.runs);
      for (std::uint64_t run = from; run < to; ++run) {
        if (must_stop(options) || !simulator.run(run)) return;
        if (report.ends[run] != SimulatedEnd::Fault) continue;
        const std::lock_guard<std::mutex> hold(lock);
        if (run > first_fault) continue;
        first_fault = run;
        report.first_fault = simulator.fault(run);
      }
      const std::uint64_t so_far = done.fetch_add(to - from) + to - from;
      if (tells && options.on_progress) options.on_progress(so_far);
    }
  };
  std::vector<std::thread> others;
  for (u32 k = 1; k < options.threads; ++k) {
    if (!start_thread(others, [&] { work(false); })) break;
  }
  work(true);
  for (std::thread& other : others) other.join();
  report.is_complete = done.load() == options.runs;
  BIP_ASSERT(report.is_complete || must_stop(options), "{} of {} runs", done.load(), options.runs);
  return report;
}

}  // namespace bip::rt
