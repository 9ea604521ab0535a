// The loop of a run: see run_loop.hpp.
#include "runtime/engine/run_loop.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "bip/assert.hpp"
#include "bip/process.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/profile.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/ask.hpp"
#include "runtime/engine/code_replacement.hpp"
#include "runtime/engine/collect_strings.hpp"

namespace bip::rt {

namespace {

// With --stats the enabled set is sampled between so many compiled steps.
constexpr u64 kStepsPerSample = u64{1} << 20;
// Between two reports of progress: some tenths of a second.
constexpr u64 kStepsPerProgress = u64{1} << 22, kQuietStepsPerProgress = u64{1} << 16;
// After so many quiet steps it asks what they do not change: strings to collect, new code, progress. Few, for steps
// with C++ may be long and make many strings.
constexpr u64 kQuietStepsPerLook = 64;
static_assert(kQuietStepsPerProgress % kQuietStepsPerLook == 0);

void write_text(std::FILE* file, const std::string& text) { std::fwrite(text.data(), 1, text.size(), file); }

}  // namespace

RunLoop::RunLoop(const Image& image, const RunOptions& options, const Record& recorded, std::uint64_t seed,
                 Output& output, const RunFiles& files)
    : image_(image),
      options_(options),
      recorded_(recorded),
      seed_(seed),
      output_(output),
      files_(files),
      new_code_(options.new_code),
      core_(image, {.progress = options.maximal_progress ? MaximalProgress::On : MaximalProgress::Off}),
      scheduler_(options.policy, seed),
      timed_(options.policy, options.asap || options.interactive, seed),
      feed_(core_),
      interrupt_guard_(&feed_.waker()),
      wall_(options.speed > 0 ? options.speed : 1),
      writes_(output.writes_steps()) {}

RunResult RunLoop::run() {
  BIP_ASSERT(phase_ == Phase::Created, "a RunLoop runs once");
  if (!open_events()) {
    (void)files_.trace.close();
    (void)files_.record.close();
    return {End::Fault, 0, 2};
  }
  begin_record();
  initialize();
  if (is_sound_ && !resume_run()) {
    (void)files_.trace.close();
    (void)files_.record.close();
    return {End::Fault, 0, 2};
  }
  start_real_time();
  start_measuring();
  if (is_sound_ && options_.engine == Engine::Threads) run_on_threads();
  if (is_sound_ && has_nodes(options_.engine)) run_on_nodes();
  while (phase_ != Phase::Ended) advance();
  finish();
  return result_;
}

// -- Phases --

bool RunLoop::open_events() {
  BIP_ASSERT(phase_ == Phase::Created, "phase {}", static_cast<int>(phase_));
  Result<bool> are_read = true;
  if (is_replay()) are_read = feed_.replay(options_.replay_path, is_interrupted);
  if (are_read && !options_.events_path.empty()) are_read = feed_.read(options_.events_path, is_interrupted);
  // The first look for a step ends a run that was interrupted here.
  if (!are_read && !is_interrupted()) {
    std::fprintf(files_.err, "error: %s\n", printable(are_read.error()).c_str());
    return false;
  }
  phase_ = Phase::EventsOpened;
  return true;
}

void RunLoop::begin_record() {
  if (!files_.record.is_open()) return;
  std::string text;
  Record record;
  record.model = image_.name;
  record.seed = seed_;
  record.policy = options_.policy;
  record.asap = options_.asap;
  record.maximal_progress = options_.maximal_progress;
  record.draws_resumes = draws_resumes(image_, options_);
  record.tells_returns = options_.speed > 0 && core_.actions().any();
  append_record_head(text, record);
  files_.record.write(text);
  feed_.record(&files_.record);
}

void RunLoop::initialize() {
  BIP_ASSERT(phase_ == Phase::EventsOpened, "phase {}", static_cast<int>(phase_));
  // Models that draw numbers by rand() run alike wherever they run.
  if (image_.ffi != nullptr) std::srand(static_cast<unsigned>(seed_));
  core_.seed_draws(seed_);
  if (draws_resumes(image_, options_)) timed_.prepare(core_);
  is_sound_ = core_.initialize();
  if (is_sound_ && core_.is_timed()) timed_.start(core_);
  else if (is_sound_) scheduler_.start(core_);
  phase_ = Phase::Initialized;
}

// False: the file is none of this model.
bool RunLoop::resume_run() {
  if (!options_.checkpoint_path.empty()) checkpoint_signal_ = std::make_unique<CheckpointSignal>();
  if (options_.resume_path.empty()) return true;
  const std::string problem = resume(core_, options_.resume_path, resumed_);
  if (problem.empty()) return true;
  std::fprintf(files_.err, "error: --resume: %s: %s\n", printable(options_.resume_path).c_str(),
               printable(problem).c_str());
  return false;
}

// The wall clock starts when the initial state is known; then what may ask for the time: threads of event sources.
void RunLoop::start_real_time() {
  BIP_ASSERT(phase_ == Phase::Initialized && !sleeps_, "phase {}", static_cast<int>(phase_));
  sleeps_ = core_.is_timed() && options_.speed > 0;
  const int priority = options_.real_time_priority;
  if (sleeps_) real_time_thread_ = std::make_unique<RealTimeThread>(priority != 0);
  wall_.start(core_.now());
  if (sleeps_) feed_.follow(wall_);
  if (sleeps_) feed_.open_pool(core_);
  if (recorded_.tells_returns) core_.actions().await_returns(nullptr);
  feed_.warn(files_.err);
  if (options_.relaxed) feed_.relax();
  if (is_sound_ && !is_replay() && options_.events_path.empty()) is_sound_ = feed_.open_sources(core_);
  // Threads inherit a priority: it is raised when all of them are there.
  if (real_time_thread_ && priority != 0) {
    real_time_thread_->raise(priority);
    const std::string& problem = real_time_thread_->problem();
    if (!problem.empty()) std::fprintf(files_.err, "warning: %s\n", problem.c_str());
  }
}

void RunLoop::start_measuring() {
  BIP_ASSERT(!core_.is_timed() || !can_be_compiled(), "compiled steps in a model with time");
  is_compiled_ = can_be_compiled();
  is_quiet_ = can_be_quiet();
  if (is_sound_ && options_.profile != nullptr) options_.profile->start(core_.tables());
  started_ = std::chrono::steady_clock::now();
  cpu_started_ = std::clock();
  if (is_sound_ && options_.engine == Engine::Batch)
    batch_ = std::make_unique<BatchEngine>(core_, scheduler_, options_, output_);
}

void RunLoop::run_on_threads() {
  BIP_ASSERT(phase_ == Phase::Initialized, "phase {}", static_cast<int>(phase_));
  threaded_ = run_threads(core_, scheduler_, options_, output_);
  result_.steps = threaded_.steps;
  end_with(threaded_.end);
}

void RunLoop::run_on_nodes() {
  BIP_ASSERT(phase_ == Phase::Initialized, "phase {}", static_cast<int>(phase_));
  const Tables& tables = core_.tables();
  const PriorityTables& rules = core_.priorities();
  Distribution distribution = distribute(
      tables, rules, options_.placement != nullptr ? *options_.placement : place_atoms(tables, rules, options_.nodes));
  distribution.history = resumed_.history;
  const Result<NetworkFaults> faults = read_faults(options_.network_faults, distribution.placement.nodes);
  BIP_ENSURE(faults && distribution.crossing.empty(), "what cannot run was refused");
  if (options_.engine == Engine::Distributed) {
    distributed_ = run_distributed(core_, distribution, options_, seed_, output_, resumed_.steps);
  } else {
    static_cast<SimulatedResult&>(distributed_) =
        run_simulated(core_, distribution, *faults, options_, seed_, output_, resumed_.steps);
  }
  result_.steps = distributed_.steps;
  end_with(distributed_.error.empty() ? distributed_.end : End::Interrupted);
}

void RunLoop::finish() {
  BIP_ASSERT(phase_ == Phase::Ended, "phase {}", static_cast<int>(phase_));
  seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count();
  if (options_.profile != nullptr) options_.profile->finish(seconds_);
  own_cpu_seconds_ = static_cast<double>(std::clock() - cpu_started_) / CLOCKS_PER_SEC;
  if (options_.before_end) options_.before_end();
  report_end();
  end_record();
  close_files();
  compare_with_recorded_end();
  if (options_.stats) print_statistics();
}

// -- One turn of the loop --

void RunLoop::advance() {
  BIP_ASSERT(phase_ == Phase::Initialized, "phase {}", static_cast<int>(phase_));
  if (const std::optional<End> end = find_end()) return end_with(*end);
  if (take_new_code()) return;
  output_.foresee(core_);
  switch (wait()) {
    case Due::Event: return;
    case Due::Fault: return end_with(End::Fault);
    case Due::Stopped: return end_with(End::Interrupted);
    case Due::Deadlock: return end_with(end_without_step(core_));
    case Due::Step: return take_steps();
  }
}

// Ends that are known before time passes. A replay ends where the record was ended from outside; its deadlocks and
// faults come again by themselves.
std::optional<End> RunLoop::find_end() const {
  if (!is_sound_) return End::Fault;
  if (result_.steps >= options_.limit) return End::Limit;
  const bool was_ended = recorded_.has_end && (recorded_.end == End::Limit || recorded_.end == End::Interrupted);
  if (was_ended && result_.steps == recorded_.steps && feed_.looks() == recorded_.looks) return recorded_.end;
  // With a limit of its own it goes on as if no more events had come.
  const bool is_cut = is_replay() && !recorded_.has_end && options_.limit == RunOptions{}.limit;
  if (is_cut && feed_.is_record_over(core_)) return End::Interrupted;
  return std::nullopt;
}

bool RunLoop::take_new_code() {
  if (!is_new_code_ready()) return false;
  core_.take_new_code(new_code_->install());
  new_code_ = nullptr;
  is_compiled_ = can_be_compiled();
  if (is_compiled_) core_.steps().drop_programs();
  return true;
}

Due RunLoop::wait() {
  if (core_.is_timed()) return timed_.wait(core_, feed_);
  if (is_interrupted()) return Due::Stopped;
  return core_.candidate_count() == 0 ? Due::Deadlock : Due::Step;
}

void RunLoop::take_steps() {
  BIP_ASSERT(core_.candidate_count() != 0, "a step is due in a state without candidates");
  if (batch_ && batch_->is_on()) take_batch();
  else if (is_compiled_) take_compiled_steps();
  else if (is_quiet_) take_quiet_steps();
  else take_one_step();
}

void RunLoop::take_batch() {
  const u64 most = steps_before_collection(core_, options_.limit - result_.steps);
  result_.steps += batch_->advance(result_.steps, most, is_sound_);
  if (is_sound_) collect_strings(core_);
}

void RunLoop::take_compiled_steps() {
  u64 most = options_.limit - result_.steps;
  if (options_.stats) {
    enabled_sizes_.add(core_.candidate_count());
    most = std::min(most, kStepsPerSample);
  }
  if (writes_) most = std::min<u64>(most, Core::kHistory);
  if (options_.on_progress) most = std::min(most, kStepsPerProgress);
  most = steps_before_collection(core_, most);
  BIP_ASSERT(can_be_compiled(), "steps of this run are taken one by one");
  const u64 done = scheduler_.run_steps(core_, most, is_interrupted, is_sound_, options_.profile);
  BIP_ASSERT(done <= most, "{} steps of {}", done, most);
  is_step_faulty_ = !is_sound_;
  if (is_sound_) collect_strings(core_);
  result_.steps += done;
  if (options_.on_progress) options_.on_progress(result_.steps);
  if (writes_) output_.record(core_.history().recent(done + (is_sound_ ? 0 : 1)));
}

// The same steps as one by one; what else a turn of the loop does would be a tenth of the work.
void RunLoop::take_quiet_steps() {
  BIP_ASSERT(can_be_quiet() && result_.steps < options_.limit, "{} steps of {}", result_.steps, options_.limit);
  const bool samples = options_.stats;
  do {
    // Parts end at multiples, so that none misses a report.
    u64 left = std::min(options_.limit - result_.steps, kQuietStepsPerLook - result_.steps % kQuietStepsPerLook);
    const u64 end = result_.steps + left;
    do {
      if (samples) enabled_sizes_.add(core_.candidate_count());
      const EnabledSet::Position at = scheduler_.choose(core_);
      is_sound_ = core_.take(at);
      scheduler_.fired(at.interaction);
    } while (is_sound_ && --left != 0 && core_.candidate_count() != 0 && !is_interrupted());
    result_.steps = end - left;
    is_step_faulty_ = !is_sound_;
    if (!is_sound_) return;
    collect_strings(core_);
    if (options_.on_progress && result_.steps % kQuietStepsPerProgress == 0) options_.on_progress(result_.steps);
  } while (result_.steps < options_.limit && core_.candidate_count() != 0 && !is_interrupted() && !is_new_code_ready());
}

void RunLoop::take_one_step() {
  if (options_.stats) enabled_sizes_.add(core_.candidate_count());
  EnabledSet::Position at{};
  if (choose(at) == Choice::InputEnded) return end_with(End::Interrupted);
  if (sleeps_ && !is_in_time(at)) return;
  BIP_ASSERT(core_.enabled().has(at), "interaction {} is no candidate", at.interaction);
  if (writes_) output_.step(core_, at, result_.steps, core_.enabled().number(at));
  fire(at);
}

RunLoop::Choice RunLoop::choose(EnabledSet::Position& at) {
  if (!options_.interactive) {
    at = core_.is_timed() ? timed_.choice() : scheduler_.choose(core_);
    return Choice::Made;
  }
  std::uint64_t k = 0;
  output_.list(core_, result_.steps);
  std::FILE* const input = options_.input == nullptr ? stdin : options_.input;
  if (!ask_candidate(input, files_.out, core_.candidate_count(), k)) return Choice::InputEnded;
  at = core_.position(k);
  return Choice::Made;
}

// In real time: does the step start before its interval is over? If not, that is a fault, or with --relaxed a warning.
bool RunLoop::is_in_time(EnabledSet::Position at) {
  const i64 late = wall_.in_model(wall_.note_late(core_.now()));
  if (!wall_.is_too_late(core_.now() + late, core_.now())) return true;
  if (!wall_.is_too_late(core_.now() + late, limiting_.latest(core_, timed_))) return true;
  if (core_.time().is_resumed(core_.candidate(at))) return true;
  const i64 last = timed_.latest(core_), actual = core_.now() + late;
  if (options_.relaxed) {
    const Fault violation = core_.time().late_step(core_.candidate(at), last, actual);
    std::fprintf(files_.err, "warning: %s\n", violation.what.c_str());
    return true;
  }
  is_sound_ = core_.time().fail_late(core_.candidate(at), last, actual);
  return false;
}

void RunLoop::fire(EnabledSet::Position at) {
  if (options_.profile != nullptr) options_.profile->begin_step();
  if (core_.is_timed()) {
    is_sound_ = core_.time().take(at);
    timed_.fired(at.interaction);
    is_sound_ = is_sound_ && feed_.resume(core_);
  } else {
    is_sound_ = core_.take(at);
    scheduler_.fired(at.interaction);
  }
  is_step_faulty_ = !is_sound_;
  if (!is_sound_) return;
  if (options_.profile != nullptr) options_.profile->end_step(at.interaction);
  collect_strings(core_);
  ++result_.steps;
}

void RunLoop::end_with(End end) {
  BIP_ASSERT(phase_ != Phase::Ended, "the run ends twice");
  BIP_ASSERT(end != End::Limit || result_.steps >= options_.limit || recorded_.has_end, "{} steps of {}", result_.steps,
             options_.limit);
  result_.end = end;
  phase_ = Phase::Ended;
}

// -- The end --

void RunLoop::report_end() {
  BIP_ASSERT((result_.end == End::Fault) == static_cast<bool>(core_.fault()), "the end {}, and the fault {}",
             result_.end, core_.fault().code);
  output_.end(core_, result_.end, result_.steps);
  if (options_.show_state) write_text(files_.out, state_text(core_));
  if (result_.end == End::Fault) {
    write_text(files_.err, fault_text(core_, seed_, result_.steps, options_.show_source) + last_steps());
    // Scripts made for the published engine look at its numbers.
    result_.exit_code = options_.format == TraceFormat::Bip2 ? published_exit_code(core_.fault().code) : 1;
  }
  if (!distributed_.error.empty()) {
    std::fprintf(files_.err, "error: %s\n", distributed_.error.c_str());
    result_.exit_code = 1;
  } else if (!distributed_.lost_nodes.empty()) {
    std::fprintf(files_.err, "error[R0030]: %s", distributed_.lost_nodes.c_str());
    result_.exit_code = 1;
  } else if (!distributed_.warning.empty()) {
    std::fprintf(files_.err, "warning[R0030]: %s", distributed_.warning.c_str());
  }
  if (distributed_.checkpoints != 0)
    std::fprintf(files_.err, "bipc: go on after step %llu by `--resume %s`\n",
                 static_cast<unsigned long long>(distributed_.checkpoint), printable(options_.checkpoint_path).c_str());
  // As a shell says of a program that the signal ended; the end of --interactive's input is none.
  if (result_.end == End::Interrupted && is_interrupted()) result_.exit_code = 128 + interrupting_signal();
}

// The steps before a run-time error, where standard output does not show them. The engines that take several steps at
// once have no such order.
std::string RunLoop::last_steps() const {
  constexpr u64 kShown = 5;
  if (!options_.silent || options_.engine != Engine::Sequential) return {};
  const u64 fired = result_.steps + (is_step_faulty_ ? 1 : 0);
  const u64 count = std::min(fired, kShown);
  std::string text = count == 0 ? "" : "  last steps:\n";
  u64 number = fired - count;
  for (const InteractionId interaction : core_.history().recent(count)) {
    text += "    #";
    append_number(text, number++);
    text += "  ";
    append_interaction(text, core_, interaction);
    text += '\n';
  }
  return text;
}

void RunLoop::end_record() {
  if (!files_.record.is_open()) return;
  Record record;
  record.end = result_.end;
  record.steps = result_.steps;
  record.looks = feed_.looks();
  std::string text;
  append_record_end(text, record);
  files_.record.write(text);
}

void RunLoop::close_files() {
  const bool is_trace_written = files_.trace.close();
  if (!files_.record.close() || !is_trace_written) result_.exit_code = kOutputLost;
}

void RunLoop::compare_with_recorded_end() {
  if (!recorded_.has_end || (result_.end == recorded_.end && result_.steps == recorded_.steps)) return;
  std::fprintf(files_.err, "error: %s: recorded were %llu steps and the end `%s`\n",
               printable(options_.replay_path).c_str(), static_cast<unsigned long long>(recorded_.steps),
               name_of(recorded_.end));
  result_.exit_code = 1;
}

void RunLoop::print_statistics() {
  if (sleeps_) {
    std::string text;
    wall_.append_histogram(text);
    if (core_.actions().any()) text += "budgets overrun: " + std::to_string(feed_.overruns()) + '\n';
    write_text(files_.err, text);
  }
  double cpu_seconds = own_cpu_seconds_;
  for (const NodeUse& node : distributed_.use) cpu_seconds += static_cast<double>(node.cpu) / 1e6;
  print_run_statistics(files_.err, core_, enabled_sizes_, result_.steps, seconds_, cpu_seconds);
  if (batch_ && batch_->is_on()) {
    std::fprintf(files_.err, "parts %u, shared interactions %zu, steps beside each other %llu\n", batch_->parts(),
                 batch_->shared(), static_cast<unsigned long long>(batch_->beside()));
  } else if (batch_) {
    std::fprintf(files_.err, "one part: the system does not come apart, or has steps without compiled code\n");
  }
  if (has_nodes(options_.engine)) print_node_statistics();
  if (threaded_.threads != 0) {
    std::fprintf(files_.err, "threads %u, atoms at work at once %u, actions handed over %llu\n", threaded_.threads,
                 threaded_.most_busy, static_cast<unsigned long long>(threaded_.handed_over));
  }
}

void RunLoop::print_node_statistics() {
  const auto number = [](u64 value) { return static_cast<unsigned long long>(value); };
  const u64 messages = distributed_.messages();
  const u64 border = distributed_.border_steps;
  std::fprintf(files_.err,
               "steps of several nodes %llu, messages %llu (%.2f a step of several nodes: %llu offers, %llu begins)\n",
               number(border), number(messages),
               border == 0 ? 0.0 : static_cast<double>(messages) / static_cast<double>(border),
               number(distributed_.offers), number(distributed_.begins));
  if (distributed_.locks != 0) {
    std::fprintf(files_.err, "of split conflict sets: %llu locks, %llu releases, %llu wakes\n",
                 number(distributed_.locks), number(distributed_.releases), number(distributed_.wakes));
  }
  const NetworkCounts& network = distributed_.network;
  if (options_.engine == Engine::Distributed) {
    std::fprintf(files_.err, "frames %llu, sent again %llu, bytes %llu, refused %llu; nodes there after %.3f s\n",
                 number(network.frames), number(network.again), number(distributed_.bytes),
                 number(distributed_.refused), static_cast<double>(distributed_.started) / 1e9);
    if (writes_)
      std::fprintf(files_.err, "bytes of steps before they were written: %llu at most\n",
                   number(distributed_.most_waiting_bytes));
    print_processor_use();
    return;
  }
  std::fprintf(files_.err, "frames %llu, sent again %llu, lost %llu, doubled %llu; simulated time %.3f s\n",
               number(network.frames), number(network.again), number(network.lost), number(network.doubled),
               static_cast<double>(distributed_.time) / 1e9);
}

// Of each node in the order of the placement.
void RunLoop::print_processor_use() {
  std::fprintf(files_.err, "CPU seconds of the nodes:");
  bool is_any_lost = false;
  for (const NodeUse& node : distributed_.use) {
    std::fprintf(files_.err, " %.3f", static_cast<double>(node.cpu) / 1e6);
    is_any_lost = is_any_lost || node.is_lost;
  }
  std::fprintf(files_.err, "; of the launcher: %.3f\nCPU ns/step of the nodes:", own_cpu_seconds_);
  for (const NodeUse& node : distributed_.use) {
    if (node.steps == 0) std::fprintf(files_.err, " -");
    else std::fprintf(files_.err, " %.1f", static_cast<double>(node.cpu) * 1e3 / static_cast<double>(node.steps));
  }
  std::fprintf(files_.err, "%s\n", is_any_lost ? "; of lost nodes: up to their last sign" : "");
}

bool RunLoop::can_be_quiet() const {
  return !writes_ && !options_.interactive && options_.profile == nullptr && !recorded_.has_end && !core_.is_timed();
}

bool RunLoop::is_new_code_ready() const {
  return new_code_ != nullptr && new_code_->is_ready.load(std::memory_order_acquire);
}

// Compiled steps know no time, and leave nothing behind but the numbers of their interactions.
bool RunLoop::can_be_compiled() const {
  return (!writes_ || output_.records_only()) && !options_.interactive && scheduler_.knows_steps() &&
         !core_.is_timed() && core_.steps().has_steps();
}

}  // namespace bip::rt
