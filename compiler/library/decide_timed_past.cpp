// Verdicts about invariants that look back (`always (happens start implies once happens calibrate)`) of models with
// time: see decide.hpp. A monitor beside the zone graph decides (runtime/explore/zone_monitor.cpp).
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/library/decide.hpp"
#include "compiler/library/point_of_run.hpp"
#include "compiler/library/timed_verdict.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/limits.hpp"
#include "compiler/system/uses_time.hpp"
#include "runtime/core/text.hpp"
#include "runtime/explore/counterexample.hpp"

namespace bip::library {

Verdict decide_timed_past(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                          const std::string& note, const verify::CancellationToken& token) {
  const verify::Formula& formula = question.formula;
  if (std::optional<Verdict> refused = refuse_offers(request, c, question)) return std::move(*refused);
  if (!can_monitor(formula))
    return refuse(request, c, question,
                  {"`previously` for a model with time", "time that passes is no point of its own",
                   "`once E` says that E was true at some point before, or now"});
  if (request.wants_certificate)
    return refuse(request, c, question,
                  {"a certificate for an invariant that looks back, of a model with time",
                   system::first_timed(*c.system), "without `--certificate` it is decided"});
  if (has_undetermined_values(*c.system)) return unknown_because_of_values(*c.system);
  const verify::CancellationToken cancellation = token.within(request.timeout);
  Executor executor(MachineCode::Fresh);
  if (!executor.prepare(c, request.backend, Optimisation::Auto)) return {};
  const rt::Image& image = c.lowered->image;
  const rt::ZoneReport found =
      rt::explore_monitor(image, zone_options(request, c, question, cancellation), monitor_of(formula));
  nlohmann::ordered_json json{{"format", "bipc-verdict"}, {"version", 1}, {"verdict", "unknown"}};
  json["property"] = formula.text;
  json["zones"] = found.zones;
  std::string text;
  int exit_code = kUnknown;
  std::optional<FoundRun> run;
  if (found.has_match && found.are_paths_known) {
    constexpr rt::CounterexampleEnd kEnd = rt::CounterexampleEnd::State;
    const rt::CounterexampleText described =
        rt::describe_counterexample(image, rt::MaximalProgress::On, kEnd, found.match, kStepsShown);
    text = described.steps + described.error +
           fmt::format("violated[V0005]: `{}`   ({}, at {})\n", formula.text,
                       rt::counted(found.match.steps.size(), "step"), time_text(found.match.end));
    json["verdict"] = "violated";
    json["steps"] = found.match.steps.size();
    json["time"] = found.match.end;
    exit_code = kViolated;
    run = found_run(request, image, kEnd, found.match, json);
  } else if (found.end == rt::ExploreEnd::Complete && found.inexact.empty() && !found.has_match) {
    json["verdict"] = "holds";
    json["method"] = "exhaustive";
    text = fmt::format("holds: `{}`: true at each point of all runs through {}\n", formula.text, size_text(found));
    text += error_note(image, found);
    exit_code = kOk;
  } else {
    text = unknown_text(found, found.has_match, cancellation, json);
  }
  text += note;
  json["text"] = text;
  Verdict verdict = verdict_of(std::move(json), std::move(text), exit_code);
  verdict.counterexample = std::move(run);
  return verdict;
}

}  // namespace bip::library
