// Verdicts about models with time: see decide.hpp. Reported runs have been taken by a core; parts of the model that
// cannot be followed exactly are named and prevent a verdict.

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/library/decide.hpp"
#include "compiler/library/add_run.hpp"
#include "compiler/library/timed_verdict.hpp"
#include "compiler/library/verify_text.hpp"
#include "compiler/lower/code_facts.hpp"
#include "compiler/pipeline/error_sources.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/limits.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/net/unread_data.hpp"
#include "compiler/verify/portfolio/counted_property.hpp"
#include "compiler/verify/timed/prove_pairs.hpp"
#include "compiler/verify/timed/prove_time.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/evidence/counterexample_text.hpp"
#include "compiler/verify/evidence/reached_zones.hpp"
#include "runtime/core/text.hpp"
#include "runtime/explore/counterexample.hpp"
#include "runtime/explore/follow_path.hpp"

namespace bip::library {

namespace {

// Of the time: the rest is the whole zone graph's.
constexpr double kShareOfParts = 3;
// Memory for the question about errors, which the user did not ask: zones of hundreds of clocks are megabytes each.
constexpr std::uint64_t kErrorMegabytes = 256;

void refuse(Compilation& c, const std::string& what) {
  c.diags.report(Diag::kB1900, c.root_range, what).note(system::first_timed(*c.system));
}

// What a location offers depends on the instant.
void ask(const verify::Property& property, rt::ExploreOptions& options) {
  options.predicate = [&property](const rt::Core& core) { return verify::is_broken(property, core); };
  for (const verify::PropertyNode& node : property.nodes) {
    if (node.kind == verify::PropertyKind::CanConnector) options.predicate_connectors.push_back(node.owner);
    if (node.kind == verify::PropertyKind::CanPort) options.predicate_atoms.push_back(node.owner);
  }
}

// Describes the state at the end of the path: by the property that it breaks, or by the atoms that wait there for ever.
std::string end_text(const rt::Image& image, const verify::Question& question, const rt::ZoneReport& found) {
  rt::Core core(image);
  const auto ignore = [](std::uint64_t, std::uint64_t) {};
  const std::uint64_t taken = rt::follow_path(core, rt::CounterexampleEnd::State, found.match, ignore, [] {});
  if (taken != found.match.steps.size() || core.fault()) return {};
  return question.what == verify::QuestionKind::NoLocalDeadlock ? verify::stuck_state(core, found.stuck, taken)
                                                                : verify::broken_state(core, question.property, taken);
}

// Parts are small and seen once: the interpreter, whatever back end the model has.
rt::PartReport explore_system(const System& part, const rt::ExploreOptions& options, const rt::PartQuestion& question) {
  const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(part, "part");
  const interp::Interpreter interpreter(*lowered);
  return rt::explore_part(lowered->image, options, question);
}

std::string neighbourhoods_text(const verify::TimeProof& proof) {
  return rt::counted(proof.neighbourhoods, "neighbourhood") + " of at most " + rt::counted(proof.largest, "component");
}

std::string proof_text(const verify::TimeProof& proof, const verify::Question& question) {
  const std::string invariants = rt::counted(proof.invariants, "invariant");
  if (proof.alike != 0)
    return fmt::format("holds: `{}`: by the zones of {}, two of which stand for any two of {} that are alike\n",
                       question.property.text, rt::counted(proof.largest, "component"), proof.alike);
  if (question.what == verify::QuestionKind::State)
    return fmt::format("holds: `{}`: by {} and the zones of {}\n", question.property.text, invariants,
                       neighbourhoods_text(proof));
  if (proof.neighbourhoods == 0)
    return "deadlock-free: no deadlock, by " + invariants + ", and no time lock, for nothing holds time up\n";
  return "deadlock-free: no deadlock and no time lock, by " + invariants + " and the zones of " +
         neighbourhoods_text(proof) + '\n';
}

// Of the proof by parts.
std::string stats_text(const verify::TimeProof& proof) {
  const std::string graphs = rt::counted(proof.explored, "zone graph") + " of " + rt::counted(proof.zones, "zone") +
                             ", " + rt::counted(proof.invariants, "invariant");
  return "by parts: " + (proof.is_proved ? "proved" : "not proved, " + proof.reason) + "; " +
         (proof.neighbourhoods == 0 ? "" : neighbourhoods_text(proof) + ", ") + graphs + '\n';
}

nlohmann::ordered_json parts_json(const verify::TimeProof& proof) {
  nlohmann::ordered_json json{{"proved", proof.is_proved}, {"neighbourhoods", proof.neighbourhoods},
                              {"largest", proof.largest},  {"graphs", proof.explored},
                              {"zones", proof.zones},      {"invariants", proof.invariants}};
  if (proof.alike != 0) json["alike"] = proof.alike;
  if (!proof.is_proved) json["reason"] = proof.reason;
  return json;
}

}  // namespace

bool can_fault_in_guards(const System& system) {
  const auto can_fault = [&](ExprId guard, StmtId up) { return lower::code_facts(system.code, guard, up).may_fault; };
  if (std::any_of(system.priorities.begin(), system.priorities.end(),
                  [&](const Priority& rule) { return can_fault(rule.guard, {}); }))
    return true;
  return std::any_of(system.connector_types.begin(), system.connector_types.end(), [&](const ConnectorType& type) {
    return std::any_of(type.clauses.begin(), type.clauses.end(),
                       [&](const Clause& clause) { return can_fault(clause.guard, clause.up); });
  });
}

std::string limit_text(const rt::ZoneReport& found, const verify::CancellationToken& cancellation) {
  if (!found.inexact.empty()) return found.inexact + ", which zones cannot follow";
  switch (found.end) {
    case rt::ExploreEnd::Time: return "the time is over";
    case rt::ExploreEnd::Memory: return "the memory does not suffice";
    case rt::ExploreEnd::Stopped: return cancellation.is_cancelled() ? "interrupted" : "the time is over";
    case rt::ExploreEnd::Complete:
    case rt::ExploreEnd::States: break;
  }
  return "the limit of zones is reached";
}

std::string size_text(const rt::ZoneReport& found) {
  return rt::counted(found.zones, "zone") + " of " + rt::counted(found.locations, "location");
}

std::string unknown_text(const rt::ZoneReport& found, bool has_run, const verify::CancellationToken& cancellation,
                         nlohmann::ordered_json& json) {
  const std::string reason =
      has_run ? "the core could not take the way that was found" : limit_text(found, cancellation);
  json["reason"] = reason;
  return "unknown: " + reason + ", after " + size_text(found) + '\n';
}

std::optional<Verdict> refuse_offers(const VerifyRequest& request, Compilation& c, const verify::Question& question) {
  const std::vector<verify::Property>& states = question.formula.states;
  if (std::none_of(states.begin(), states.end(), verify::asks_offers)) return std::nullopt;
  // What can be done is no part of a location.
  return refuse(request, c, question,
                {"`can` in a property of runs of a model with time", "what can be done changes while time passes",
                 "`happens` says that it is done, `component@PLACE` where it may be"});
}

rt::ExploreOptions zone_options(const VerifyRequest& request, const Compilation& c, const verify::Question& question,
                                const verify::CancellationToken& cancellation) {
  rt::ExploreOptions options;
  options.bytes = request.megabytes * kMega;
  options.is_stopped = [&cancellation] { return cancellation.is_over(); };
  options.unread_cells = verify::find_unread_cells(*c.system, c.lowered->image, data_of(question));
  return options;
}

FoundRun found_run(const VerifyRequest& request, const rt::Image& image, rt::CounterexampleEnd end,
                   const rt::TimedPath& path, nlohmann::ordered_json& json) {
  FoundRun run{end, path, {}, std::nullopt};
  if (request.wants_run) add_run(json, rt::counterexample_json(image, rt::MaximalProgress::On, end, path));
  if (request.wants_trace)
    run.trace = rt::trace_of_counterexample(image, rt::MaximalProgress::On, end, path, rt::TraceFormat::Json);
  return run;
}

std::string time_text(std::int64_t ticks) {
  std::string text;
  rt::append_time(text, ticks);
  return text;
}

std::string endless_text(rt::CounterexampleEnd end, std::size_t steps, std::optional<std::size_t> cycle) {
  if (end == rt::CounterexampleEnd::TimeLock) return "there the run ends, for time cannot pass and nothing can be done";
  if (!cycle) return "from then on time can pass for ever without a step";
  return *cycle + 1 == steps
             ? fmt::format("step #{} can repeat for ever, and time goes on", steps - 1)
             : fmt::format("the steps #{} to #{} can repeat for ever, and time goes on", *cycle, steps - 1);
}

Verdict verdict_of(nlohmann::ordered_json json, std::string text, int exit_code) {
  Verdict verdict;
  verdict.is_answered = true;
  verdict.exit_code = exit_code;
  verdict.text = std::move(text);
  verdict.json = std::move(json);
  return verdict;
}

Verdict unknown_because_of_values(const System& system) {
  const std::string reason = system.code.has_cpp() ? "zones cannot follow what the model's C++ computes"
                                                   : "zones cannot follow the random numbers that the model draws";
  const nlohmann::ordered_json json{{"format", "bipc-verdict"},
                                    {"version", 1},
                                    {"verdict", "unknown"},
                                    {"reason", reason},
                                    {"text", "unknown: " + reason + '\n'}};
  return verdict_of(json, "unknown: " + reason + '\n', kUnknown);
}

std::string error_note(const rt::Image& image, const rt::ZoneReport& found) {
  if (!found.has_error) return {};
  if (!found.are_paths_known) return kEndsInError;
  rt::Core core(image);
  (void)rt::follow_path(
      core, rt::CounterexampleEnd::Error, found.error, [](std::uint64_t, std::uint64_t) {}, [] {});
  return core.fault() ? error_note(core.fault().what) : kEndsInError;
}

// The note of a verdict that holds by parts, which say nothing of errors: whether a run can end in one. The zone graph
// of the whole decides it, within kErrorSeconds.
static std::string error_remark_of_zones(const Compilation& c, const VerifyRequest& request,
                                         const verify::CancellationToken& token) {
  if (!can_end_in_error(*c.system)) return {};
  const verify::CancellationToken soon = token.within(kErrorSeconds);
  const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(*c.system, c.root_name);
  const interp::Interpreter interpreter(*lowered);
  rt::ExploreOptions options;
  options.bytes = std::min(request.megabytes, kErrorMegabytes) * kMega;
  options.is_stopped = [&soon] { return soon.is_over(); };
  options.unread_cells = verify::find_unread_cells(*c.system, lowered->image, {});
  const rt::ZoneReport found = rt::explore_zones(lowered->image, options);
  if (found.has_error) return error_note(lowered->image, found);
  return found.end == rt::ExploreEnd::Complete && found.inexact.empty() ? std::string() : kErrorsNotAsked;
}

// Returns the verdict of a proof by localization or by pairs.
static Verdict verdict_of_parts(const verify::TimeProof& proof, const verify::Question& question,
                                const std::string& remark, const std::string& note, const std::string& stats,
                                nlohmann::ordered_json json) {
  std::string text = proof_text(proof, question);
  text += remark;
  text += note;
  json["verdict"] = name_of(question.what, Finding::Holds);
  json["method"] = "parts";
  json["text"] = text;
  Verdict verdict = verdict_of(std::move(json), std::move(text), kOk);
  verdict.figures = stats;
  return verdict;
}

Verdict decide_timed(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                     const std::string& note, const verify::CancellationToken& token) {
  const bool asks_partial = question.what == verify::QuestionKind::NoLocalDeadlock;
  if (asks_partial && request.wants_certificate) {
    refuse(c, "a certificate for `--partial` of a model with time");
    return {};
  }
  if (has_undetermined_values(*c.system)) return unknown_because_of_values(*c.system);
  const verify::CancellationToken cancellation = token.within(request.timeout);
  nlohmann::ordered_json json{{"format", "bipc-verdict"}, {"version", 1}, {"verdict", "unknown"}};
  std::string stats;
  const bool asks_state = question.what == verify::QuestionKind::State;
  if (asks_state) json["property"] = question.property.text;
  // A certificate is the zone graph, of two components or of the whole.
  if (request.wants_certificate && asks_state && c.system->priorities.empty() &&
      system::first_resume(*c.system).empty() && !can_fault_in_guards(*c.system)) {
    const verify::TimeProof proof = verify::prove_state_by_pairs(*c.system, question.property, explore_system,
                                                                 cancellation.within(request.timeout / kShareOfParts),
                                                                 {}, request.megabytes * (kMega / 2));
    if (request.stats) stats = stats_text(proof);
    if (request.stats) json["parts"] = parts_json(proof);
    if (proof.is_proved && !proof.rows.empty()) {
      Verdict verdict = verdict_of_parts(proof, question, error_remark_of_zones(c, request, cancellation), note, stats,
                                         std::move(json));
      verdict.certificate =
          verify::certificate_head(question, *c.system, c.root_name) + "method pairs\n" + proof.rows + "end\n";
      return verdict;
    }
  }
  if (!request.wants_certificate && (asks_state || question.what == verify::QuestionKind::DeadlockFreedom)) {
    const verify::CancellationToken soon = cancellation.within(request.timeout / kShareOfParts);
    verify::TimeProof proof;
    // Of components that are alike but for their numbers the first ones stand for all.
    const std::optional<verify::Property> first =
        asks_state ? verify::with_first_of_array(question.property, *c.system) : std::nullopt;
    if (first) proof = verify::prove_state_by_pairs(*c.system, *first, explore_system, soon);
    if (proof.is_proved) json["quantifier"] = quantifier_json(question.property);
    if (!proof.is_proved)
      proof = asks_state ? verify::prove_state_in_time(*c.system, question.property, explore_system, soon)
                         : verify::prove_time(*c.system, explore_system, soon);
    if (asks_state && !proof.is_proved) {
      verify::TimeProof by_pairs = verify::prove_state_by_pairs(*c.system, question.property, explore_system,
                                                                cancellation.within(request.timeout / kShareOfParts));
      if (by_pairs.is_proved) proof = std::move(by_pairs);
    }
    if (request.stats) {
      stats = stats_text(proof);
      json["parts"] = parts_json(proof);
    }
    if (proof.is_proved)
      return verdict_of_parts(proof, question, error_remark_of_zones(c, request, cancellation), note, stats,
                              std::move(json));
  }
  Executor executor(MachineCode::Fresh);
  if (!executor.prepare(c, request.backend, Optimisation::Auto)) return {};
  const rt::Image& image = c.lowered->image;
  rt::ZoneReport found;
  std::string certificate, refused;
  {
    rt::ExploreOptions options = zone_options(request, c, question, cancellation);
    if (asks_state) ask(question.property, options);
    if (request.wants_certificate) {
      verify::ZoneCollector zones(*c.system, image, options.unread_cells, request.megabytes * (kMega / 2));
      found = rt::explore_zones(image, options, [&](const rt::ListedLocation& location) { zones.add(location); });
      refused = zones.problem();
      certificate = std::move(zones).rows();
    } else {
      found = asks_partial ? rt::explore_local_deadlocks(image, options) : rt::explore_zones(image, options);
    }
  }
  const bool asks_errors = question.what == verify::QuestionKind::NoErrors;
  const bool asks_match = asks_state || asks_partial;
  const bool is_violated = asks_errors  ? found.has_error
                           : asks_match ? found.has_match
                                        : found.has_deadlock || found.has_time_lock;
  const bool is_complete = found.end == rt::ExploreEnd::Complete && found.inexact.empty();
  if (request.wants_certificate && !is_violated && found.inexact.empty() && !cancellation.is_cancelled()) {
    if (refused.empty() && found.has_error && can_fault_in_guards(*c.system))
      refused = "guards of connectors or priorities that end in an error";
    if (refused.empty() && asks_state && !system::first_resume(*c.system).empty() &&
        verify::asks_offers(question.property))
      refused = "`resume`, of a property with `can`,";
    if (!refused.empty()) refused = "a certificate for a model with time and " + refused;
    else if (!is_complete || certificate.empty())
      refused = "a certificate for a model with time whose zones are too many for --timeout and --memory";
    if (!refused.empty()) {
      refuse(c, refused);
      return {};
    }
  }
  if (asks_errors) json["property"] = "errors";
  if (asks_partial) json["property"] = "partial";
  json["zones"] = found.zones;
  std::string text;
  int exit_code = kUnknown;
  std::optional<FoundRun> run;
  if (is_violated && found.are_paths_known) {
    const rt::FoundPath first = asks_errors  ? rt::FoundPath{rt::CounterexampleEnd::Error, &found.error}
                                : asks_match ? rt::FoundPath{rt::CounterexampleEnd::State, &found.match}
                                             : rt::first_of(found);
    rt::CounterexampleText described =
        rt::describe_counterexample(image, rt::MaximalProgress::On, first.end, *first.path, kStepsShown);
    if (asks_match) described.steps += end_text(image, question, found);
    json["verdict"] =
        first.end == rt::CounterexampleEnd::TimeLock ? "time lock" : name_of(question.what, Finding::Violated);
    json["steps"] = first.path->steps.size();
    text = described.steps + described.error;
    exit_code = kViolated;
    run = found_run(request, image, first.end, *first.path, json);
  } else if (is_complete && !is_violated) {
    const std::string name = name_of(question.what, Finding::Holds);
    json["verdict"] = name;
    json["method"] = "exhaustive";
    const std::string what = asks_errors    ? "no error in "
                             : asks_partial ? "no component waits for ever in "
                                            : "no deadlock and no time lock in ";
    text = asks_state ? fmt::format("holds: `{}`: true in {}\n", question.property.text, size_text(found))
                      : name + ": " + what + size_text(found) + '\n';
    text += error_note(image, found);
    exit_code = kOk;
  } else {
    text = unknown_text(found, is_violated, cancellation, json);
  }
  text += note;
  json["text"] = text;
  Verdict verdict = verdict_of(std::move(json), std::move(text), exit_code);
  verdict.figures = std::move(stats);
  verdict.counterexample = std::move(run);
  if (request.wants_certificate && exit_code == kOk)
    verdict.certificate =
        verify::certificate_head(question, *c.system, c.root_name) + "method zones\n" + certificate + "end\n";
  return verdict;
}

}  // namespace bip::library
