// `run --explore`: the exploration of runtime/explore, reported as the published engine does or in one line of our own.
#include <algorithm>
#include <thread>

#include "bip/run.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/explore/counterexample.hpp"

namespace bip::rt {

namespace {

void write(std::FILE* file, const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), file);
  std::fflush(file);
}

}  // namespace

ExploreResult explore(const Image& image, const RunOptions& options, std::FILE* out, std::FILE* err) {
  if (has_time(image)) {
    std::fputs("error: --explore: a model with time has states without end, one an instant\n", err);
    ExploreResult refused;
    refused.complete = false;
    refused.exit_code = 2;
    return refused;
  }
  const InterruptGuard guard;
  const bool is_bip2 = options.format == TraceFormat::Bip2;
  if (is_bip2) write(out, kPublishedBegin);
  ExploreOptions wanted;
  wanted.progress = options.maximal_progress ? MaximalProgress::On : MaximalProgress::Off;
  wanted.limit = options.limit;
  wanted.threads = std::max(1u, std::thread::hardware_concurrency());
  wanted.is_stopped = is_interrupted;
  u64 dots = 0;
  if (is_bip2) {
    wanted.on_progress = [&](const ExploreProgress& progress) {
      std::string text;
      for (; dots * kStatesPerDot < progress.expanded; ++dots) text += '.';
      if (!text.empty()) write(out, text);
    };
  }
  const ExploreReport found = explore_states(image, wanted);
  std::string text, error_text;
  if (found.has_error) {
    const CounterexampleText counterexample =
        describe_counterexample(image, wanted.progress, CounterexampleEnd::Error, found.error, 0);
    error_text = counterexample.error;
    if (!is_bip2 && !options.silent && !counterexample.names.empty())
      text = "error in the last step of " + counterexample.names + "\n";
  }
  if (is_bip2) {
    text = published_line(found);
  } else {
    if (!options.silent && found.has_deadlock && found.are_paths_known) {
      const CounterexampleText counterexample =
          describe_counterexample(image, wanted.progress, CounterexampleEnd::Deadlock, found.deadlock, 0);
      text = "deadlock after " + counted(found.deadlock.size(), "step") +
             (counterexample.names.empty() ? "" : ": " + counterexample.names) + "\n" + text;
    }
    text += summary_line(found);
  }
  write(out, text);
  write(err, error_text);
  return {.states = found.states,
          .deadlocks = found.deadlocks,
          .errors = found.errors,
          .complete = found.end == ExploreEnd::Complete,
          .exit_code = found.errors > 0                    ? 1
                       : found.end == ExploreEnd::Complete ? 0
                                                           : 4};
}

}  // namespace bip::rt
