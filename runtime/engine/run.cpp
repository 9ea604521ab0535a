// The sequential engine: initialize, then choose and fire until the limit, a deadlock, a fault or Ctrl-C.
//
// With nothing to write the loop builds no strings. SIGINT is caught while a run is on, and the handler that was there
// before is put back; the flag it sets and whom it wakes are the only globals of the runtime: a signal handler can
// reach nothing else.
#include "bip/run.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>

#include "bip/real_time_thread.hpp"
#include "runtime/core/profile.hpp"
#include "runtime/engine/ask.hpp"
#include "runtime/engine/batch_engine.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/new_code.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/engine/scheduler.hpp"
#include "runtime/engine/timed_scheduler.hpp"
#include "runtime/engine/real_time.hpp"
#include "runtime/engine/threads.hpp"

namespace bip::rt {

namespace {

volatile std::sig_atomic_t interrupted = 0;
std::atomic<Waker*> interrupt_wakes{nullptr};
extern "C" void bip_on_interrupt(int) {
  interrupted = 1;
  if (Waker* const waker = interrupt_wakes.load()) waker->wake();
}

// A file to write, or null after a report.
std::FILE* open_file(const std::string& path, std::FILE* err) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) std::fprintf(err, "error: cannot write `%s`: %s\n", path.c_str(), std::strerror(errno));
  return file;
}
bool close_file(std::FILE* file, const std::string& path, std::FILE* err) {
  if (file == nullptr || std::fclose(file) == 0) return true;
  std::fprintf(err, "error: cannot write `%s`: %s\n", path.c_str(), std::strerror(errno));
  return false;
}

// The record says how the run was started and where it ended.
bool begin_replay(const Image& image, RunOptions& options, Record& record, std::FILE* err) {
  std::string error;
  if (!read_record(options.replay_path, record, error)) {
    std::fprintf(err, "error: %s\n", error.c_str());
    return false;
  }
  if (record.model != image.name) {
    std::fprintf(err, "error: %s: a run of `%s` was recorded, this is `%s`\n", options.replay_path.c_str(),
                 record.model.c_str(), image.name);
    return false;
  }
  options.seed = record.seed;
  options.has_seed = true;
  options.policy = record.policy;
  options.asap = record.asap;
  options.maximal_progress = record.maximal_progress;
  options.speed = 0;
  // One more than recorded tells a run that goes on.
  if (record.has_end) options.limit = std::min(options.limit, record.steps + 1);
  return true;
}

// Was the recorded run ended here? Deadlocks and faults come again by themselves.
bool ends_here(const Record& record, u64 steps, u64 looks) {
  return record.has_end && (record.end == End::Limit || record.end == End::Interrupted) && steps == record.steps &&
         looks == record.looks;
}

// How many interactions the states offered: of every state, or now and then where compiled steps follow each other.
constexpr u64 kStepsBetweenLooks = u64{1} << 20;
struct EnabledSizes {
  u64 looks = 0, sum = 0, least = 0, most = 0;
  void look(u64 count) {
    least = looks == 0 ? count : std::min(least, count);
    most = std::max(most, count);
    sum += count;
    ++looks;
  }
};

// Of the steps alone, without the initial state.
void print_stats(std::FILE* err, const Core& core, const EnabledSizes& enabled, std::uint64_t steps, double seconds,
                 double cpu_seconds) {
  const double scale = steps == 0 ? 0 : 1e9 / static_cast<double>(steps);
  std::fprintf(err, "steps %llu, seconds %.6f, ns/step %.1f, CPU ns/step %.1f\n",
               static_cast<unsigned long long>(steps), seconds, seconds * scale, cpu_seconds * scale);
  if (enabled.looks != 0) {
    std::fprintf(err, "enabled %.1f on average, %llu to %llu, in %llu states\n",
                 static_cast<double>(enabled.sum) / static_cast<double>(enabled.looks),
                 static_cast<unsigned long long>(enabled.least), static_cast<unsigned long long>(enabled.most),
                 static_cast<unsigned long long>(enabled.looks));
  }
  if (const SearchWork& work = core.search_work(); work.searches != 0) {
    std::fprintf(err,
                 "searches of maximal interactions %llu, configurations looked at %llu, connectors evaluated %llu, "
                 "sets looked at as ranges %llu\n",
                 static_cast<unsigned long long>(work.searches), static_cast<unsigned long long>(work.configurations),
                 static_cast<unsigned long long>(work.connectors), static_cast<unsigned long long>(work.range_looks));
  }
  const MemoryUse use = core.memory();
  const auto a_row = [](u64 bytes, std::size_t rows) {
    return rows == 0 ? 0.0 : static_cast<double>(bytes) / static_cast<double>(rows);
  };
  std::fprintf(err, "bytes %.1f an atom beside its data, %.1f a connector; %llu in all, of them %llu data\n",
               a_row(use.atoms, core.image().atoms.size),
               a_row(use.connectors, core.image().connectors.size + core.tables().interactions.size() -
                                         core.tables().connector_interactions),
               static_cast<unsigned long long>(use.all()), static_cast<unsigned long long>(use.data));
}

// Why such a run cannot be; null: it can.
const char* refusal(const Image& image, const RunOptions& options) {
  if (options.engine != Engine::Sequential) {
    if (has_time(image)) return "an engine with several threads does not run models with time";
    if (options.interactive || options.debug) return "--interactive and --debug need the sequential engine";
    if (options.profile != nullptr) return "--profile needs the sequential engine";
    if (!options.record_path.empty() || !options.replay_path.empty())
      return "--record and --replay need the sequential engine";
    if (options.engine == Engine::Threads && options.format == TraceFormat::Bip2)
      return "--trace-format=bip2 needs the sequential engine: it lists what each state offers";
  }
  if (options.format == TraceFormat::Binary && has_time(image))
    return "--trace-format=binary does not record models with time";
  if (options.format == TraceFormat::Mcap || options.format == TraceFormat::Perfetto) {
    if (options.trace_path.empty())
      return "--trace-format=mcap and perfetto need --trace: they are no text for standard output";
    if (options.engine != Engine::Sequential) return "--trace-format=mcap and perfetto need the sequential engine";
  }
  return nullptr;
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

std::uint64_t draw_seed() {
  std::uint32_t seed = 0;
  if (std::FILE* file = std::fopen("/dev/urandom", "rb")) {
    const std::size_t read = std::fread(&seed, sizeof seed, 1, file);
    std::fclose(file);
    if (read == 1) return seed;
  }
  return static_cast<std::uint32_t>(std::chrono::steady_clock::now().time_since_epoch().count());
}

RunResult run(const Image& image, const RunOptions& given, std::FILE* out, std::FILE* err) {
  RunOptions options = given;
  Record record;
  if (!options.replay_path.empty() && !begin_replay(image, options, record, err)) return {End::Fault, 0, 2};
  if (options.explore) {
    const ExploreResult found = explore(image, options, out, err);
    return {found.complete ? End::Deadlock : End::Limit, 0, found.exit_code};
  }
  if (const char* why = refusal(image, options); why != nullptr) {
    std::fprintf(err, "error: %s\n", why);
    return {End::Fault, 0, 2};
  }
  RunResult result;
  ThreadedResult threaded;
  std::FILE* file = nullptr;
  std::FILE* record_file = nullptr;
  if (!options.trace_path.empty() && (file = open_file(options.trace_path, err)) == nullptr) return {End::Fault, 0, 2};
  if (!options.record_path.empty() && (record_file = open_file(options.record_path, err)) == nullptr) {
    (void)close_file(file, options.trace_path, err);
    return {End::Fault, 0, 2};
  }
  // What comes is large: no second buffer.
  if (file != nullptr) std::setvbuf(file, nullptr, _IONBF, 0);
  const std::uint64_t seed = options.has_seed ? options.seed : draw_seed();
  Output output(options, seed, out, file, image);
  output.begin(image);

  Core core(image, {.progress = options.maximal_progress ? MaximalProgress::On : MaximalProgress::Off});
  Scheduler scheduler(options.policy, seed);
  EventFeed feed(core);
  const InterruptGuard guard(&feed.waker());
  const bool is_replay = !options.replay_path.empty();
  if (std::string error; (is_replay && !feed.replay(options.replay_path, error)) ||
                         (!options.events_path.empty() && !feed.read(options.events_path, error))) {
    std::fprintf(err, "error: %s\n", error.c_str());
    (void)close_file(file, options.trace_path, err);
    (void)close_file(record_file, options.record_path, err);
    return {End::Fault, 0, 2};
  }
  if (record_file != nullptr) {
    std::string text;
    append_record_head(text, {false, image.name, seed, options.policy, options.asap, options.maximal_progress,
                              options.speed > 0 && core.has_async()});
    std::fwrite(text.data(), 1, text.size(), record_file);
    feed.record(record_file);
  }
  TimedScheduler timed(options.policy, options.asap || options.interactive, seed);
  const bool writes = output.writes_steps();
  // Models that draw numbers by rand() run alike wherever they run.
  if (image.ffi != nullptr) std::srand(static_cast<unsigned>(seed));
  bool sound = core.initialize();
  if (sound && core.is_timed()) timed.start(core);
  else if (sound) scheduler.start(core);
  RealTime wall(options.speed > 0 ? options.speed : 1);
  const bool sleeps = core.is_timed() && options.speed > 0;
  std::unique_ptr<RealTimeThread> thread;
  if (sleeps) thread = std::make_unique<RealTimeThread>(options.real_time_priority != 0);
  wall.start(core.now());
  if (sleeps) feed.follow(wall);
  if (sleeps) feed.open_pool(core);
  if (record.tells_returns) core.await_returns(nullptr);
  feed.warn(err);
  // Their threads may ask for the time.
  if (sound && !is_replay && options.events_path.empty()) sound = feed.open_sources(core);
  if (thread && options.real_time_priority != 0) {
    thread->raise(options.real_time_priority);
    if (!thread->problem().empty()) std::fprintf(err, "warning: %s\n", thread->problem().c_str());
  }
  const auto can_be_compiled = [&] {
    return (!writes || output.records_only()) && !options.interactive && options.policy == Policy::Uniform &&
           !core.is_timed() && core.has_steps();
  };
  bool is_compiled = can_be_compiled();
  if (sound && options.profile != nullptr) options.profile->start(core.tables());
  const auto started = std::chrono::steady_clock::now();
  const std::clock_t cpu_started = std::clock();
  if (sound && options.engine == Engine::Threads) {
    threaded = run_threads(core, scheduler, options, output);
    result.end = threaded.end;
    result.steps = threaded.steps;
  }
  std::unique_ptr<BatchEngine> batch;
  if (sound && options.engine == Engine::Batch) batch = std::make_unique<BatchEngine>(core, scheduler, options, output);
  Due due = Due::Step;
  EnabledSizes enabled;
  while (options.engine != Engine::Threads || !sound) {
    if (!sound) {
      result.end = End::Fault;
    } else if (result.steps >= options.limit) {
      result.end = End::Limit;
    } else if (ends_here(record, result.steps, feed.looks())) {
      result.end = record.end;
    } else if (options.new_code != nullptr && options.new_code->is_ready.load(std::memory_order_acquire)) {
      core.take_new_code(options.new_code->install());
      options.new_code = nullptr;
      is_compiled = can_be_compiled();
      if (is_compiled) core.drop_programs();
      continue;
    } else if (output.foresee(core); (due = core.is_timed() ? timed.wait(core, feed) : Due::Step) == Due::Fault) {
      result.end = End::Fault;
    } else if (due == Due::Event) {
      continue;
    } else if (due == Due::Stopped || (interrupted != 0 && !core.is_timed())) {
      result.end = End::Interrupted;
    } else if (due == Due::Deadlock || core.candidate_count() == 0) {
      result.end = End::Deadlock;
    } else if (batch && batch->is_on()) {
      result.steps += batch->advance(result.steps, options.limit - result.steps, sound);
      continue;
    } else if (is_compiled) {
      u64 most = options.limit - result.steps;
      if (options.stats) {
        enabled.look(core.candidate_count());
        most = std::min(most, kStepsBetweenLooks);
      }
      const u64 done = core.run_steps(scheduler.prng(), writes ? std::min<u64>(most, Core::kHistory) : most,
                                      is_interrupted, sound, options.profile);
      result.steps += done;
      if (writes) output.record(core.recent_interactions(done + (sound ? 0 : 1)));
      continue;
    } else {
      if (options.stats) enabled.look(core.candidate_count());
      EnabledSet::Position at{};
      if (options.interactive) {
        std::uint64_t k = 0;
        output.list(core, result.steps);
        if (!ask_candidate(options.input == nullptr ? stdin : options.input, out, core.candidate_count(), k)) {
          result.end = End::Interrupted;
          break;
        }
        at = core.position(k);
      } else {
        at = core.is_timed() ? timed.choice() : scheduler.choose(core);
      }
      if (sleeps) {
        const i64 late = wall.in_model(wall.note_late(core.now()));
        if (wall.is_too_late(core.now() + late, timed.latest(core))) {
          (void)core.fail_late(core.candidate(at), timed.latest(core), core.now() + late);
          if (!options.relaxed) {
            sound = false;
            continue;
          }
          std::fprintf(err, "warning: %s\n", core.fault().what.c_str());
        }
      }
      if (writes) output.step(core, at, result.steps, core.number(at));
      if (options.profile != nullptr) options.profile->begin_step();
      if (core.is_timed()) {
        sound = core.take_timed(at);
        timed.fired(at.interaction);
      } else {
        sound = core.take(at);
        scheduler.fired(at.interaction);
      }
      if (!sound) continue;
      if (options.profile != nullptr) options.profile->end_step(at.interaction);
      ++result.steps;
      continue;
    }
    break;
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - started;
  if (options.profile != nullptr) options.profile->finish(seconds.count());
  const double cpu_seconds = static_cast<double>(std::clock() - cpu_started) / CLOCKS_PER_SEC;

  output.end(core, result.end, result.steps);
  if (result.end == End::Fault) {
    const std::string text = fault_text(core, seed, result.steps);
    std::fwrite(text.data(), 1, text.size(), err);
    // Scripts made for the published engine look at its numbers.
    result.exit_code = output.bip2_format() ? published_exit_code(core.fault().code) : 1;
  }
  // As a shell says of a program that SIGINT ended; the end of --interactive's input is none.
  if (result.end == End::Interrupted && interrupted != 0) result.exit_code = 128 + SIGINT;
  if (record_file != nullptr) {
    std::string text;
    append_record_end(text, {true, "", 0, options.policy, false, true, false, result.end, result.steps, feed.looks()});
    std::fwrite(text.data(), 1, text.size(), record_file);
  }
  const bool is_trace_written = close_file(file, options.trace_path, err);
  if (!close_file(record_file, options.record_path, err) || !is_trace_written) result.exit_code = 2;
  if (record.has_end && (result.end != record.end || result.steps != record.steps)) {
    std::fprintf(err, "error: %s: recorded were %llu steps and the end `%s`\n", options.replay_path.c_str(),
                 static_cast<unsigned long long>(record.steps), name_of(record.end));
    result.exit_code = 1;
  }
  if (options.stats && sleeps) {
    std::string text;
    wall.append_histogram(text);
    if (core.has_async()) text += "budgets overrun: " + std::to_string(feed.overruns()) + '\n';
    std::fwrite(text.data(), 1, text.size(), err);
  }
  if (options.stats) print_stats(err, core, enabled, result.steps, seconds.count(), cpu_seconds);
  if (options.stats && batch && batch->is_on()) {
    std::fprintf(err, "parts %u, shared interactions %zu, steps beside each other %llu\n", batch->parts(),
                 batch->shared(), static_cast<unsigned long long>(batch->beside()));
  } else if (options.stats && batch) {
    std::fprintf(err, "one part: the system does not come apart, or has steps without compiled code\n");
  }
  if (options.stats && threaded.threads != 0) {
    std::fprintf(err, "threads %u, atoms at work at once %u, actions handed over %llu\n", threaded.threads,
                 threaded.most_busy, static_cast<unsigned long long>(threaded.handed_over));
  }
  return result;
}

}  // namespace bip::rt
