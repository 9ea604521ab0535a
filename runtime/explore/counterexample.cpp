// See counterexample.hpp.
#include "runtime/explore/counterexample.hpp"

#include <algorithm>
#include <memory>

#include "runtime/core/deadlock_explanation.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/text.hpp"
#include "runtime/explore/follow_path.hpp"
#include "runtime/trace/trace.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::rt {

namespace {

// Nothing was drawn, so there is no seed to tell.
std::string without_seed(std::string text) {
  constexpr const char* kSeed = ", seed 0)";
  if (const std::size_t at = text.find(kSeed); at != std::string::npos) text.erase(at, std::string(kSeed).size() - 1);
  return text;
}

const char* beginning_of(ExploreEnd end) {
  switch (end) {
    case ExploreEnd::Complete: return "explored: ";
    case ExploreEnd::States: return "limit: at least ";
    case ExploreEnd::Memory: return "memory limit: at least ";
    case ExploreEnd::Time: return "time limit: at least ";
    case ExploreEnd::Stopped: return "interrupted: at least ";
  }
  return "";
}

// The published engine writes `0 error`.
std::string published_count(u64 n, const char* what) { return n == 0 ? "0 " + std::string(what) : counted(n, what); }

}  // namespace

const char* name_of(ExploreEnd end) {
  switch (end) {
    case ExploreEnd::Complete: return "complete";
    case ExploreEnd::States: return "limit";
    case ExploreEnd::Memory: return "memory";
    case ExploreEnd::Time: return "time";
    case ExploreEnd::Stopped: return "interrupted";
  }
  return "";
}

std::string published_line(const ExploreReport& report) {
  std::string text = " found " + published_count(report.states, "reachable state") + ", " +
                     published_count(report.deadlocks, "deadlock") + ", and " + published_count(report.errors, "error");
  if (report.end == ExploreEnd::Stopped) text += " (interrupted)";
  else if (report.end != ExploreEnd::Complete) text += " (limit reached)";
  return text + "\n";
}

TimedPath at_once(const Path& path) {
  TimedPath timed;
  for (const u64 choice : path) timed.steps.push_back({0, choice});
  return timed;
}

FoundPath first_of(const ZoneReport& found) {
  if (found.has_deadlock) return {CounterexampleEnd::Deadlock, &found.deadlock};
  if (found.has_time_lock) return {CounterexampleEnd::TimeLock, &found.time_lock};
  if (found.has_error) return {CounterexampleEnd::Error, &found.error};
  return {};
}

std::string counted(u64 n, const char* what) {
  std::string text;
  append_number(text, n);
  text += ' ';
  text += what;
  if (n != 1) text += 's';
  return text;
}

// Only of models that declare how they end.
template <class Report>
static std::string finals_of(const Report& report) {
  return report.has_final_states ? ", " + counted(report.finals, "final state") : "";
}

std::string summary_line(const ExploreReport& report) {
  return beginning_of(report.end) + counted(report.states, "reachable state") + ", " + counted(report.steps, "step") +
         ", " + counted(report.deadlocks, "deadlock") + ", " + counted(report.errors, "error") + finals_of(report) +
         "\n";
}

std::string summary_line(const ZoneReport& report) {
  const char* beginning = report.inexact.empty() ? beginning_of(report.end) : "not exact: at least ";
  return beginning + counted(report.zones, "zone") + " of " + counted(report.locations, "location") + ", " +
         counted(report.steps, "step") + ", " + counted(report.deadlocks, "deadlock") + ", " +
         counted(report.time_locks, "time lock") + ", " + counted(report.errors, "error") + finals_of(report) + "\n";
}

CounterexampleText describe_counterexample(const Image& image, MaximalProgress progress, CounterexampleEnd end,
                                           const TimedPath& path, std::size_t max_lines) {
  CounterexampleText text;
  Core core(image, {.progress = progress});
  StepWriter writer;
  i64 last = 0;
  const auto tell = [&](u64 number, u64 choice) {
    const Candidate candidate = core.candidate(choice);
    text.names += text.names.empty() ? "" : ", ";
    append_candidate(text.names, core, candidate);
    if (number < max_lines) writer.step(text.steps, core, candidate, number);
    else if (number == max_lines) text.steps += "… and " + counted(path.steps.size() - number, "more step") + "\n";
    last = core.now();
  };
  const u64 taken = follow_path(core, end, path, tell, [] {});
  if (core.fault()) {
    text.error = without_seed(fault_text(core, 0, taken));
  } else if (end == CounterexampleEnd::Deadlock && core.candidate_count() == 0) {
    if (core.now() > last) {
      text.steps += "time passes to ";
      append_time(text.steps, core.now());
      text.steps += '\n';
    }
    text.steps += without_seed(deadlock_story(core, taken, 0));
  }
  return text;
}

CounterexampleText describe_counterexample(const Image& image, MaximalProgress progress, CounterexampleEnd end,
                                           const Path& path, std::size_t max_lines) {
  return describe_counterexample(image, progress, end, at_once(path), max_lines);
}

std::string trace_of_counterexample(const Image& image, MaximalProgress progress, CounterexampleEnd end,
                                    const TimedPath& path, TraceFormat format) {
  std::string text;
  Core core(image, {.progress = progress});
  const std::unique_ptr<TraceSink> sink = row_of(format).make();
  // A replay takes the path whatever the policy was.
  sink->begin(text, {.image = &image, .policy = "first", .maximal_progress = progress == MaximalProgress::On});
  const u64 taken = follow_path(
      core, end, path, [&](u64 number, u64 choice) { sink->step(text, core, core.position(choice), number, choice); },
      [&] { sink->foresee(core); });
  const End ended = core.fault() ? End::Fault : core.candidate_count() != 0 ? End::Limit : end_without_step(core);
  sink->end(text, core, ended, taken);
  return text;
}

std::string trace_of_counterexample(const Image& image, MaximalProgress progress, const Path& path,
                                    TraceFormat format) {
  return trace_of_counterexample(image, progress, CounterexampleEnd::Deadlock, at_once(path), format);
}

}  // namespace bip::rt
