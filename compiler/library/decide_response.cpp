// Verdicts about `E leads to F` and `eventually F` of models with time, within T or at any time: see decide.hpp. The
// zone graph with an observer decides (runtime/explore/zone_response.cpp, zone_lasso.cpp); what it cannot treat is
// refused by name or unknown with the reason.
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/library/decide.hpp"
#include "compiler/library/point_of_run.hpp"
#include "compiler/library/timed_verdict.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/limits.hpp"
#include "compiler/system/system_ids.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/evidence/reached_zones.hpp"
#include "compiler/verify/property/expression.hpp"
#include "runtime/core/text.hpp"
#include "runtime/explore/counterexample.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::library {

namespace {

// "`a leads to b within 50 ms`   (3 steps, at 57ms)" and since when.
std::string missed_text(const verify::Formula& formula, const rt::ZoneReport& found, const rt::MissedResponse& missed) {
  const rt::TimedPath& path = found.match;
  std::string text = fmt::format("violated[{}]: `{}`   ({}, at {})\n", formula.has_limit() ? "V0006" : "V0005",
                                 formula.text, rt::counted(path.steps.size(), "step"), time_text(path.end));
  if (missed.at_step)
    text += fmt::format("  asked for by step #{}, at {}", missed.requested_by, time_text(missed.requested));
  else text += "  asked for from " + time_text(missed.requested) + " on";
  const rt::CounterexampleEnd end = found.is_match_end ? rt::CounterexampleEnd::TimeLock : rt::CounterexampleEnd::State;
  if (found.is_match_end || !formula.has_limit())
    return text + ": " + endless_text(end, path.steps.size(), found.match_cycle) + '\n';
  return text + fmt::format(": {} later it has not come\n", time_text(path.end - missed.requested));
}

// What has no answer yet, of a response without a limit. `what` is empty: it has one.
Unsupported without_an_answer(const VerifyRequest& request) {
  if (!request.fairness.is_none())
    return {"fairness for a model with time", "urgencies and invariants say what has to happen",
            "without `--fair` the property is decided"};
  return {};
}

}  // namespace

Verdict decide_response(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                        const std::string& note, const verify::CancellationToken& token) {
  const verify::Formula& formula = question.formula;
  BIP_ASSERT(formula.response, "a property of no response");
  if (std::optional<Verdict> refused = refuse_offers(request, c, question)) return std::move(*refused);
  if (!formula.has_limit()) {
    const Unsupported unsupported = without_an_answer(request);
    if (!unsupported.what.empty()) return refuse(request, c, question, unsupported);
  }
  if (has_undetermined_values(*c.system)) return unknown_because_of_values(*c.system);
  const verify::CancellationToken cancellation = token.within(request.timeout);
  Executor executor(MachineCode::Fresh);
  if (!executor.prepare(c, request.backend, Optimisation::Auto)) return {};
  const rt::Image& image = c.lowered->image;
  const verify::Formula::Response& asked = *formula.response;
  const auto at = [&formula](std::uint32_t row) {
    return [&formula, row](rt::Core& core, const rt::Candidate* candidate) {
      return is_true_at(formula, row, core, candidate);
    };
  };
  const rt::TimedResponse response{at(asked.request), at(asked.response), asked.asks_once, asked.within};
  const rt::ExploreOptions options = zone_options(request, c, question, cancellation);
  std::optional<verify::ZoneCollector> zones;
  rt::ZoneReport found;
  if (request.wants_certificate) {
    zones.emplace(*c.system, image, options.unread_cells, request.megabytes * (kMega / 2),
                  verify::ZoneObserver::OfResponse);
    found = rt::explore_response(image, options, response,
                                 [&](const rt::ListedLocation& location) { zones->add(location); });
  } else {
    found = rt::explore_response(image, options, response);
  }
  const bool is_complete = found.end == rt::ExploreEnd::Complete && found.inexact.empty();
  std::string certificate;
  if (zones && !found.has_match && found.inexact.empty() && !cancellation.is_cancelled()) {
    std::string refused = zones->problem();
    if (refused.empty() && found.has_error && can_fault_in_guards(*c.system))
      refused = "guards of connectors or priorities that end in an error";
    if (!refused.empty()) refused = "a certificate for a model with time and " + refused;
    const std::string rows = std::move(*zones).rows();
    const std::optional<std::string> text =
        is_complete && !rows.empty() ? verify::certificate_of_response(formula, found, rows, *c.system, c.root_name)
                                     : std::nullopt;
    if (refused.empty() && !text)
      refused = "a certificate for a model with time whose zones are too many for --timeout and --memory";
    if (!refused.empty()) {
      c.diags.report(Diag::kB1900, c.root_range, refused).note(system::first_timed(*c.system));
      return {};
    }
    certificate = *text;
  }
  nlohmann::ordered_json json{{"format", "bipc-verdict"}, {"version", 1}, {"verdict", "unknown"}};
  json["property"] = formula.text;
  json["zones"] = found.zones;
  std::string text;
  int exit_code = kUnknown;
  std::optional<FoundRun> run;
  if (found.has_match && found.are_paths_known) {
    const rt::CounterexampleEnd end =
        found.is_match_end ? rt::CounterexampleEnd::TimeLock : rt::CounterexampleEnd::State;
    const rt::MissedResponse missed = rt::follow_response(image, options, found.match, response);
    BIP_ASSERT(missed.requested <= found.match.end, "asked for at {}, after the end at {}", missed.requested,
               found.match.end);
    BIP_ASSERT(!found.match_cycle || *found.match_cycle <= found.match.steps.size(), "step {} of {} begins the cycle",
               *found.match_cycle, found.match.steps.size());
    const rt::CounterexampleText described =
        rt::describe_counterexample(image, rt::MaximalProgress::On, end, found.match, kStepsShown);
    text = described.steps + described.error + missed_text(formula, found, missed);
    json["verdict"] = "violated";
    json["steps"] = found.match.steps.size();
    json["requested"] = missed.requested;
    json["time"] = found.match.end;
    json["ends"] = found.is_match_end;
    if (found.match_cycle) json["cycle"] = *found.match_cycle;
    exit_code = kViolated;
    run = found_run(request, image, end, found.match, json);
    run->cycle = found.match_cycle;
  } else if (is_complete && !found.has_match) {
    json["verdict"] = "holds";
    json["method"] = "exhaustive";
    text = fmt::format("holds: `{}`: true of all runs through {}\n", formula.text, size_text(found));
    text += error_note(image, found);
    if (found.has_standing_cycle)
      text += "note: steps can repeat for ever while time stands still (Zeno); such runs do not count\n";
    exit_code = kOk;
  } else {
    text = unknown_text(found, found.has_match, cancellation, json);
  }
  text += note;
  json["text"] = text;
  Verdict verdict = verdict_of(std::move(json), std::move(text), exit_code);
  verdict.counterexample = std::move(run);
  if (exit_code == kOk) verdict.certificate = std::move(certificate);
  return verdict;
}

}  // namespace bip::library
