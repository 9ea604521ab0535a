// See timed_models.hpp. Reported runs have been taken by a core; parts of the model that cannot be followed exactly are
// named and prevent a verdict.
#include "compiler/base/json_text.hpp"
#include "compiler/library/add_run.hpp"
#include "compiler/driver/timed_models.hpp"

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/base/write_file.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/interrupt_cancellation.hpp"
#include "compiler/pipeline/machine.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/terminal.hpp"
#include "compiler/system/system_ids.hpp"
#include "compiler/verify/net/unread_data.hpp"
#include "runtime/explore/counterexample.hpp"

namespace bip::driver {

namespace {

constexpr const char* kNotReplayed = "the core could not take the way to what was found\n";

const char* end_of(const rt::ZoneReport& found) { return found.inexact.empty() ? name_of(found.end) : "inexact"; }

nlohmann::ordered_json path_json(const rt::Image& image, rt::MaximalProgress progress, rt::CounterexampleEnd end,
                                 const rt::TimedPath& path, const rt::CounterexampleText& described) {
  nlohmann::ordered_json steps = nlohmann::ordered_json::array();
  for (const rt::TimedStep& step : path.steps) steps.push_back({{"time", step.at}, {"choice", step.choice}});
  nlohmann::ordered_json json{{"steps", steps}, {"end", path.end}, {"text", described.steps + described.error}};
  library::add_run(json, rt::counterexample_json(image, progress, end, path));
  return json;
}

struct PathTexts {
  rt::CounterexampleText deadlock, time_lock, error;
};

void print_json(const ExploreArguments& a, const rt::Image& image, const rt::ZoneReport& found,
                const PathTexts& texts) {
  const auto path = [&](rt::CounterexampleEnd end, const rt::TimedPath& taken, const rt::CounterexampleText& text) {
    return path_json(image, a.explore.progress, end, taken, text);
  };
  nlohmann::ordered_json json{{"format", "bipc-exploration"}, {"version", 1},
                              {"end", end_of(found)},         {"zones", found.zones},
                              {"locations", found.locations}, {"steps", found.steps},
                              {"deadlocks", found.deadlocks}, {"time_locks", found.time_locks},
                              {"errors", found.errors},       {"depth", found.depth}};
  if (found.has_final_states) json["final_states"] = found.finals;
  if (!found.inexact.empty()) json["inexact"] = found.inexact;
  if (a.stats) {
    json["seconds"] = found.seconds;
    json["bytes"] = found.bytes;
  }
  if (found.are_paths_known) {
    if (found.has_deadlock) json["deadlock"] = path(rt::CounterexampleEnd::Deadlock, found.deadlock, texts.deadlock);
    if (found.has_time_lock)
      json["time_lock"] = path(rt::CounterexampleEnd::TimeLock, found.time_lock, texts.time_lock);
    if (found.has_error) json["error"] = path(rt::CounterexampleEnd::Error, found.error, texts.error);
  }
  write_now(stdout, json_line(json) + '\n');
}

int exit_code_of(const rt::ZoneReport& found) {
  if (found.has_error) return kModelErrors;
  if (found.has_deadlock || found.has_time_lock) return kViolated;
  return found.end == rt::ExploreEnd::Complete && found.inexact.empty() ? kOk : kUnknown;
}

}  // namespace

int explore_timed(const ExploreArguments& arguments, Compilation& c) {
  const rt::Image& image = c.lowered->image;
  rt::ZoneReport found;
  {
    const InterruptCancellation interrupt;
    rt::ExploreOptions options = arguments.explore;
    options.seconds = static_cast<double>(arguments.seconds);
    options.bytes = arguments.megabytes == 0 ? available_memory() / 4 * 3 : arguments.megabytes * kMega;
    options.is_stopped = [cancellation = interrupt.token()] { return cancellation.is_cancelled(); };
    options.unread_cells = verify::find_unread_cells(*c.system, image);
    found = rt::explore_zones(image, options);
  }
  const rt::MaximalProgress maximal = arguments.explore.progress;
  PathTexts texts;
  if (found.are_paths_known) {
    if (found.has_deadlock)
      texts.deadlock =
          rt::describe_counterexample(image, maximal, rt::CounterexampleEnd::Deadlock, found.deadlock, kStepsShown);
    if (found.has_time_lock)
      texts.time_lock =
          rt::describe_counterexample(image, maximal, rt::CounterexampleEnd::TimeLock, found.time_lock, kStepsShown);
    if (found.has_error)
      texts.error = rt::describe_counterexample(image, maximal, rt::CounterexampleEnd::Error, found.error, kStepsShown);
  }
  if (const rt::FoundPath first = rt::first_of(found);
      !arguments.trace_path.empty() && first.path != nullptr && found.are_paths_known) {
    const std::string trace = rt::trace_of_counterexample(image, maximal, first.end, *first.path, arguments.format);
    if (const Result<bool> written = write_file(arguments.trace_path, trace); !written) {
      c.diags.report(Diag::kB5004, {}, arguments.trace_path, written.error());
      return report(c);
    }
  }
  if (arguments.json) {
    print_json(arguments, image, found, texts);
    return exit_code_of(found);
  }
  std::string text;
  if (!arguments.silent) {
    text = texts.deadlock.steps + texts.time_lock.steps;
    write_now(stdout, text);
    write_now(stderr, texts.time_lock.error);
    write_now(stdout, texts.error.steps);
    text = found.are_paths_known ? "" : kNotReplayed;
    if (!found.inexact.empty()) text += found.inexact + ", which zones cannot follow\n";
  }
  write_now(stdout, text + rt::summary_line(found));
  write_now(stderr, texts.error.error);
  if (arguments.stats) {
    write_now(stderr, fmt::format("zones/s {:.0f}, bytes/zone {:.1f}, depth {}, seconds {:.3f}\n",
                                  static_cast<double>(found.zones) / std::max(found.seconds, 1e-9),
                                  static_cast<double>(found.bytes) /
                                      static_cast<double>(std::max<std::uint64_t>(found.zones, 1)),
                                  found.depth, found.seconds));
  }
  return exit_code_of(found);
}

}  // namespace bip::driver
