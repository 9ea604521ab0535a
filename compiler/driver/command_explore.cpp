// `bipc explore`: visits all reachable states and prints the result in one of three forms: for people, as JSON, as the
// published engine does.
//
// Counterexamples are replayed by a core from the initial state before they are printed. A result that a limit cut off
// is labelled partial, and the properties that a reduction preserves are named.
#include <unistd.h>

#include <cstdio>

#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/driver/exploration_json.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/terminal.hpp"
#include "compiler/driver/timed_models.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/machine.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/net/unread_data.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/explore/counterexample.hpp"

namespace bip::driver {

namespace {

// What the chosen reduction means for the counts.
std::string reduction_text(const rt::ExploreReport& found, rt::StateReduction reduction) {
  if (reduction == rt::StateReduction::Por)
    return "partial-order reduction: all deadlocks are found; not all states, steps and run-time errors are seen\n";
  if (reduction == rt::StateReduction::None) return "";
  std::string text = "symmetry reduction: states that differ only by a permutation count once; interchangeable are";
  for (const std::string& group : found.groups) text += (&group == &found.groups.front() ? " " : ", ") + group;
  return text + "\n";
}

// Progress for a person who waits: a line that is written over, on a terminal.
class ExploreProgressLine {
 public:
  explicit ExploreProgressLine(bool is_wanted) : is_on_(is_wanted && isatty(STDERR_FILENO) != 0) {}
  void tell(const rt::ExploreProgress& now) {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - started_;
    if (!is_on_ || spent.count() < next_) return;
    next_ = spent.count() + 0.5;
    write_now(stderr,
              fmt::format("\r{} states, {} to do, depth {}, {} deadlocks, {} errors, {:.2f} million states/s, {} MB   ",
                          now.states, now.states - now.expanded, now.depth, now.deadlocks, now.errors,
                          static_cast<double>(now.states) / spent.count() / 1e6, now.bytes / kMega));
    is_shown_ = true;
  }
  void clear() const {
    if (is_shown_) write_now(stderr, "\r\x1b[K");
  }

 private:
  bool is_on_, is_shown_ = false;
  double next_ = 0.5;
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
};

void print_stats(const rt::ExploreReport& found) {
  const auto states = static_cast<double>(std::max<std::uint64_t>(found.states, 1));
  write_now(
      stderr,
      fmt::format("states/s {:.0f}, bytes/state {:.1f}, bits/state {}, depth {}, seconds {:.3f}, threads {}, MB {}\n",
                  states / std::max(found.seconds, 1e-9), static_cast<double>(found.bytes) / states, found.bits,
                  found.depth, found.seconds, found.threads, found.bytes / kMega));
}

int exit_code_of(const rt::ExploreReport& found) {
  if (found.errors != 0) return kModelErrors;
  if (found.deadlocks != 0) return kViolated;
  return found.end == rt::ExploreEnd::Complete ? kOk : kUnknown;
}

// Refuses what could not be explored soundly. False: a diagnostic was reported.
bool is_explorable(const ExploreArguments& a, Compilation& c) {
  const CodeTable& code = c.system->code;
  if (!a.trusts_cpp && code.has_cpp()) {
    c.diags.report(Diag::kB5041, {}, code.first_cpp())
        .help(
            "`--trust-cpp` explores it all the same: functions are then taken to depend on nothing but their "
            "arguments");
    return false;
  }
  const std::string problem = rt::reduction_problem(c.lowered->image, a.explore);
  if (problem.empty()) return true;
  c.diags.report(Diag::kB5040, {}, a.explore.reduction == rt::StateReduction::Por ? "partial-order" : "symmetry",
                 problem);
  return false;
}

rt::ExploreReport search(const ExploreArguments& a, const System& system, const rt::Image& image) {
  const rt::InterruptGuard guard;
  const bool is_bip2 = a.format == rt::TraceFormat::Bip2 && !a.json;
  rt::ExploreOptions options = a.explore;
  options.threads = a.threads == 0 ? processors() : static_cast<std::uint32_t>(std::min<std::uint64_t>(a.threads, 256));
  options.seconds = static_cast<double>(a.seconds);
  options.bytes = a.megabytes == 0 ? available_memory() / 4 * 3 : a.megabytes * kMega;
  options.is_stopped = rt::is_interrupted;
  options.unread_cells = verify::find_unread_cells(system, image);
  ExploreProgressLine progress(!is_bip2);
  std::uint64_t dots = 0;
  if (is_bip2) write_now(stdout, rt::kPublishedBegin);
  options.on_progress = [&](const rt::ExploreProgress& now) {
    progress.tell(now);
    std::string text;
    for (; is_bip2 && dots * rt::kStatesPerDot < now.expanded; ++dots) text += '.';
    if (!text.empty()) write_now(stdout, text);
  };
  rt::ExploreReport found = rt::explore_states(image, options);
  progress.clear();
  return found;
}

}  // namespace

int command_explore(const ExploreArguments& arguments) {
  Compilation c(arguments.compile);
  if (arguments.compile.emit != EmitKind::None) {
    emit_stage(c, arguments.file, arguments.optimisation);
    return report(c);
  }
  if (!compile(c, arguments.file, Stage::Image) || !check_outputs(c, {arguments.trace_path}) ||
      !check_writable(c, {arguments.trace_path}))
    return report(c);
  Executor executor(MachineCode::Fresh);
  // What is refused anyway needs none of the model's C++.
  const bool ready = is_explorable(arguments, c) && executor.prepare(c, arguments.backend, arguments.optimisation);
  if (const int code = report(c); code != 0 || !ready) return code;
  if (system::is_timed(*c.system)) return explore_timed(arguments, c);
  const rt::Image& image = c.lowered->image;
  const rt::ExploreReport found = search(arguments, *c.system, image);
  const rt::MaximalProgress maximal = arguments.explore.progress;
  ShownRuns runs;
  if (found.has_deadlock && found.are_paths_known)
    runs.deadlock =
        rt::describe_counterexample(image, maximal, rt::CounterexampleEnd::Deadlock, found.deadlock, kStepsShown);
  if (found.has_error && found.are_paths_known)
    runs.error = rt::describe_counterexample(image, maximal, rt::CounterexampleEnd::Error, found.error, kStepsShown);
  if (!arguments.trace_path.empty() && (found.has_deadlock || found.has_error) && found.are_paths_known) {
    const std::string trace = rt::trace_of_counterexample(
        image, maximal, found.has_deadlock ? found.deadlock : found.error, arguments.format);
    if (const Result<bool> written = write_file(arguments.trace_path, trace); !written) {
      c.diags.report(Diag::kB5004, {}, arguments.trace_path, written.error());
      return report(c);
    }
  }
  if (arguments.json) {
    write_now(stdout, exploration_json(arguments, image, found, runs));
  } else if (arguments.format == rt::TraceFormat::Bip2) {
    write_now(stdout, rt::published_line(found));
    write_now(stderr, runs.error.error);
  } else {
    std::string text;
    if (!arguments.silent) {
      text = runs.deadlock.steps + runs.error.steps + reduction_text(found, arguments.explore.reduction);
      if (!found.are_paths_known)
        text += "the way to what was found is not known: there was no time left to look for it\n";
    }
    write_now(stdout, text + rt::summary_line(found));
    write_now(stderr, runs.error.error);
  }
  if (arguments.stats) print_stats(found);
  return exit_code_of(found);
}

}  // namespace bip::driver
