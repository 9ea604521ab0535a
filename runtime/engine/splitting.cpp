// See splitting.hpp.
#include "runtime/engine/splitting.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "bip/assert.hpp"
#include "bip/draws.hpp"
#include "runtime/core/start_thread.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/collect_strings.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/timed_scheduler.hpp"

namespace bip::rt {
namespace {

constexpr std::uint64_t kMostLevels = 10'000;
constexpr std::uint64_t kOneIn = 5;

// SplitMix64's mixing (Steele, Lea, Flood 2014): seeds of all runs from one.
std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  std::uint64_t z = a + 0x9e3779b97f4a7c15u * (b + 1);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// Where a run climbed a level.
struct Entrance {
  State state;
  std::uint64_t steps = 0;
  bool is_initial = false;
};
enum class RunEnd : std::uint8_t { Climbed, Reached, Missed, Open, Fault, Stopped };

/// Makes the runs of one replication after the other, on one core.
class Splitter {
 public:
  Splitter(const Image& image, const SplittingOptions& options)
      : options_(options), core_(image, {.progress = options.progress}), feed_(core_) {
    has_draws_ = has_draws(image);
    core_.seed_draws(0);
    scheduler_ = TimedScheduler(Policy::Uniform, options_.asap, 0);
    scheduler_.prepare(core_);
    is_sound_ = core_.initialize();
    if (!is_sound_) return;
    scheduler_.start(core_);
    initial_.state = core_.snapshot();
    initial_.is_initial = true;
    start_ = options.importance(core_);
  }
  [[nodiscard]] bool is_sound() const { return is_sound_; }
  [[nodiscard]] std::string fault(std::uint64_t seed) const { return fault_text(core_, seed, last_.steps); }
  [[nodiscard]] bool has_fault() const { return static_cast<bool>(core_.fault()); }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  [[nodiscard]] std::uint64_t open() const { return open_; }

  /// An estimate of the probability; negative after a fault or a stop.
  double replicate(const std::vector<double>& levels, std::uint64_t seed) {
    Prng choices(seed);
    std::vector<Entrance> from{initial_}, next;
    double product = 1, sum = 0;
    for (std::size_t level = 0; level <= levels.size() && product > 0; ++level) {
      std::uint64_t reached = 0;
      next.clear();
      for (std::uint64_t k = 0; k < options_.effort; ++k) {
        const RunEnd end = run_from(from, choices, level == levels.size() ? nullptr : &levels[level]);
        if (end == RunEnd::Fault || end == RunEnd::Stopped) return -1;
        if (end == RunEnd::Open) ++open_;
        if (end == RunEnd::Reached) ++reached;
        if (end == RunEnd::Climbed) next.push_back(last_);
      }
      // A run may reach the goal past all levels that are left.
      const auto effort = static_cast<double>(options_.effort);
      sum += product * static_cast<double>(reached) / effort;
      product *= static_cast<double>(next.size()) / effort;
      from.swap(next);
    }
    return sum;
  }

  /// Levels that about one in five of trial runs climbs, from the one before. Stops at a fault, which a run meets
  /// later.
  std::vector<double> find_levels(std::uint64_t seed) {
    Prng choices(seed);
    std::vector<double> levels, highest;
    std::vector<Entrance> from{initial_}, next;
    while (levels.size() < kMostLevels) {
      std::uint64_t reached = 0;
      highest.clear();
      for (std::uint64_t k = 0; k < options_.effort; ++k) {
        const RunEnd end = run_from(from, choices, nullptr);
        if (end == RunEnd::Fault || end == RunEnd::Stopped) return levels;
        if (end == RunEnd::Reached) ++reached;
        highest.push_back(highest_);
      }
      if (reached * kOneIn >= options_.effort) break;
      std::sort(highest.begin(), highest.end());
      // Above where they began, which is the least of what they saw.
      const double least = levels.empty() ? start_ : levels.back();
      const auto above = std::upper_bound(highest.begin(), highest.end(), least);
      if (above == highest.end()) break;
      const double level = std::max(*above, highest[highest.size() - highest.size() / kOneIn - 1]);
      next.clear();
      for (std::uint64_t k = 0; k < options_.effort; ++k) {
        if (run_from(from, choices, &level) == RunEnd::Climbed) next.push_back(last_);
      }
      if (next.empty()) break;
      levels.push_back(level);
      from.swap(next);
    }
    return levels;
  }

 private:
  // From one of the entrances. The two draws are ordered here: as arguments of one call their order is the compiler's.
  RunEnd run_from(const std::vector<Entrance>& from, Prng& choices, const double* level) {
    const std::uint64_t seed = choices.next();
    return run(from[choices.below(from.size())], seed, level);
  }
  // To the entrance. What atoms draw from there on is independent of other runs from it.
  bool begin(const Entrance& from, std::uint64_t seed) {
    if (has_draws_ && from.is_initial) {
      core_.seed_draws(seed);
      return core_.initialize();
    }
    if (!core_.restore(from.state)) return false;
    // What an `initial` waits for is drawn anew.
    if (from.is_initial && core_.time().draws_resumes() && core_.time().has_initial_resume() && !core_.initialize())
      return false;
    for (u32 atom = 0; has_draws_ && atom < core_.image().atoms.size; ++atom) {
      const u32 variable = core_.tables().atom_type(atom).draws;
      if (variable != kNone) core_.write_cell(core_.tables().atoms[atom].first_cell + variable, draw_start(seed, atom));
    }
    return true;
  }
  // Until the level is climbed, if there is one, or the run is answered or ends.
  RunEnd run(const Entrance& from, std::uint64_t seed, const double* level) {
    last_.steps = from.steps;
    last_.is_initial = false;
    scheduler_ = TimedScheduler(Policy::Uniform, options_.asap, seed);
    scheduler_.prepare(core_);
    if (!begin(from, seed)) return RunEnd::Fault;
    highest_ = options_.importance(core_);
    while (true) {
      const Answer answer = answer_in(options_.query, core_, last_.steps);
      if (answer != Answer::Open) return answer == Answer::Yes ? RunEnd::Reached : RunEnd::Missed;
      const double importance = options_.importance(core_);
      highest_ = std::max(highest_, importance);
      if (level != nullptr && importance >= *level) {
        last_.state = core_.snapshot();
        return RunEnd::Climbed;
      }
      if (last_.steps >= options_.limit) return RunEnd::Open;
      if ((++steps_ & 1023u) == 0 && (is_interrupted() || (options_.is_stopped && options_.is_stopped())))
        return RunEnd::Stopped;
      switch (scheduler_.wait(core_, feed_)) {
        case Due::Event: continue;
        case Due::Stopped: return RunEnd::Stopped;
        case Due::Deadlock: return answer_at_end(options_.query) == Answer::Yes ? RunEnd::Reached : RunEnd::Missed;
        case Due::Fault: return RunEnd::Fault;
        case Due::Step: break;
      }
      const EnabledSet::Position at = scheduler_.choice();
      if (!(core_.is_timed() ? core_.time().take(at) : core_.take(at))) return RunEnd::Fault;
      ++last_.steps;
      collect_strings(core_);
    }
  }

  const SplittingOptions& options_;
  Core core_;
  EventFeed feed_;
  TimedScheduler scheduler_{Policy::Uniform, false, 0};
  Entrance initial_, last_;
  double highest_ = 0, start_ = 0;
  std::uint64_t steps_ = 0, open_ = 0;
  bool is_sound_ = false, has_draws_ = false;
};

}  // namespace

SplittingReport split(const Image& image, const SplittingOptions& options) {
  BIP_ASSERT(!options.query.is_negated && options.effort != 0 && options.replications != 0, "{} runs a level",
             options.effort);
  SplittingReport report;
  Splitter first(image, options);
  if (!first.is_sound()) {
    report.fault = first.fault(options.seed);
    return report;
  }
  report.levels = options.levels.empty() ? first.find_levels(mixed(options.seed, ~std::uint64_t{0})) : options.levels;
  report.estimates.assign(options.replications, -1);
  std::atomic<std::uint64_t> next{0}, steps{0}, open{0};
  std::mutex lock;
  std::uint64_t first_fault = ~std::uint64_t{0};
  const auto work = [&](Splitter& splitter) {
    for (std::uint64_t k = next.fetch_add(1); k < options.replications; k = next.fetch_add(1)) {
      report.estimates[k] = splitter.replicate(report.levels, mixed(options.seed, k));
      if (report.estimates[k] >= 0) continue;
      const std::lock_guard<std::mutex> hold(lock);
      if (splitter.has_fault() && k < first_fault) {
        first_fault = k;
        report.fault = splitter.fault(options.seed);
      }
      break;
    }
    steps += splitter.steps();
    open += splitter.open();
  };
  std::vector<std::thread> others;
  for (u32 k = 1; k < options.threads; ++k) {
    const bool has_begun = start_thread(others, [&] {
      Splitter splitter(image, options);
      work(splitter);
    });
    if (!has_begun) break;
  }
  work(first);
  for (std::thread& other : others) other.join();
  report.steps = steps;
  report.open = open;
  report.is_complete = std::all_of(report.estimates.begin(), report.estimates.end(), [](double e) { return e >= 0; });
  return report;
}

}  // namespace bip::rt
