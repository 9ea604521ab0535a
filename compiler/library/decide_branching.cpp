// Verdicts about properties of branching time: see decide.hpp. What the graph of states cannot treat is refused by name
// or unknown with the reason.
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/library/add_run.hpp"
#include "compiler/library/decide.hpp"
#include "compiler/library/run_text.hpp"
#include "compiler/library/verify_text.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/limits.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/branching/decide_branching.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/evidence/counterexample_text.hpp"
#include "compiler/verify/evidence/reached_states.hpp"
#include "compiler/verify/liveness/decide_runs.hpp"
#include "compiler/verify/net/unread_data.hpp"
#include "runtime/explore/counterexample.hpp"
#include "runtime/trace/trace.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::library {

namespace {

// What the property reads of the run's last state.
std::string last_state_text(const rt::Image& image, const verify::BranchingFormula& formula,
                            const verify::BranchingResult& found) {
  rt::Core core(image);
  bool is_sound = core.initialize();
  for (std::size_t at = 0; at < found.choices.size() && is_sound; ++at) is_sound = core.fire(found.choices[at]);
  return is_sound ? verify::atoms_text(core, verify::atoms_of(formula.states)) : std::string();
}

// "  no run from there reaches `robot@HOME`; 4 states can be reached from there"
std::string claim_text(const verify::ClaimOfBranches& claim, std::size_t steps) {
  BIP_ASSERT(claim.position <= steps, "a claim of the state after step {} of {}", claim.position, steps);
  const std::string where = claim.position == 0       ? "the initial state"
                            : claim.position == steps ? "there"
                                                      : fmt::format("the state after #{}", claim.position - 1);
  return fmt::format("  {} run from {} {}; {}{} can be reached from it\n", claim.has_run ? "each" : "no", where,
                     claim.of_run, claim.is_whole ? "" : "more than ", rt::counted(claim.states, "state"));
}

std::string run_text(const rt::Image& image, const verify::BranchingResult& found) {
  const bool has_ended = found.repeats && found.cycle == found.choices.size() && !found.only_errors_follow;
  return steps_text(image, {found.choices, found.cycle, has_ended}, kStepsShown);
}

std::string explanation_text(const rt::Image& image, const verify::BranchingFormula& formula,
                             const verify::BranchingResult& found) {
  std::string text = found.repeats ? std::string() : last_state_text(image, formula, found);
  for (const verify::ClaimOfBranches& claim : found.claims) text += claim_text(claim, found.choices.size());
  if (found.only_errors_follow)
    text += "  each step from there ends in a run-time error: the last state counts as one that repeats for ever\n";
  return text;
}

std::string holds_text(const rt::Image& image, const verify::BranchingFormula& formula,
                       const verify::BranchingResult& found) {
  const std::string states = rt::counted(found.states, found.is_complete ? "reachable state" : "state");
  if (!verify::begins_with_possibly(formula))
    return fmt::format("holds: `{}`: true in the {}graph of {}\n", formula.text,
                       found.is_complete ? "whole " : "first part of the ", states);
  const std::string text = run_text(image, found);
  return text +
         fmt::format("holds: `{}`: this run shows it ({}; {} visited)\n", formula.text,
                     rt::counted(found.choices.size(), "step"), states) +
         explanation_text(image, formula, found);
}

std::string violated_text(const rt::Image& image, const verify::BranchingFormula& formula,
                          const verify::BranchingResult& found) {
  return run_text(image, found) +
         fmt::format("violated[V0007]: `{}`   ({})\n", formula.text, rt::counted(found.choices.size(), "step")) +
         explanation_text(image, formula, found);
}

// False: there is none, which was said.
bool add_certificate(Compilation& c, const verify::BranchingFormula& formula, const verify::StateCollector& reached,
                     Verdict& verdict) {
  const auto refuse = [&](const std::string& what) {
    c.diags.report(Diag::kB1900, c.root_range, "a certificate for a property with `possibly` " + what)
        .help("without `--certificate` the property is decided");
    return false;
  };
  if (!reached.is_listable()) return refuse("of a model with floats, C++ data or priorities below connectors");
  const std::string rows = reached.rows();
  if (rows.empty()) return refuse("whose states are too many for `--memory`");
  const std::optional<std::string> text = verify::certificate_of_branches(formula, rows, *c.system, c.root_name);
  if (!text) return refuse("that repeats its parts too often");
  verdict.certificate = *text;
  return true;
}

// A question that this engine does not answer.
std::optional<Unsupported> unsupported(const VerifyRequest& request, const System& system) {
  if (const std::string what = system::first_timed(system); !what.empty())
    return Unsupported{"this property with `possibly` for a model with time", what,
                       "`possibly E`, `possibly always E` and `E leads to F` have answers"};
  if (!request.fairness.is_none())
    return Unsupported{"fairness for this property with `possibly`", "it is about all runs from each state",
                       "`possibly` before one word, as `possibly always E`, has an answer; this one without `--fair`"};
  return std::nullopt;
}

}  // namespace

Verdict decide_branching(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                         const std::string& note, const verify::CancellationToken& token,
                         const verify::Report& report) {
  if (const std::optional<Unsupported> what = unsupported(request, *c.system))
    return refuse(request, c, question, *what);
  Verdict verdict;
  const verify::BranchingFormula& formula = question.branching;
  verify::BranchingResult found;
  const rt::Image& image = c.lowered->image;
  Executor executor(MachineCode::Fresh);
  verify::StateCollector reached(*c.system, image, request.megabytes * (kMega / 2));
  if (has_undetermined_values(*c.system)) {
    found.reason = verify::reason_without_graph(*c.system);
  } else {
    if (!executor.prepare(c, request.backend, Optimisation::Auto)) return verdict;
    verify::LivenessOptions options;
    options.megabytes = static_cast<std::size_t>(request.megabytes);
    options.cancellation = token.within(request.timeout);
    if (request.wants_certificate) options.add_state = [&](const rt::Core& core) { reached.add(core.snapshot()); };
    else options.unread_cells = verify::find_unread_cells(*c.system, image, data_of(question));
    options.report = report;
    found = verify::decide_branching(formula, image, options);
  }
  const bool holds = found.outcome == verify::Outcome::Holds;
  if (request.wants_certificate && holds && !add_certificate(c, formula, reached, verdict)) return verdict;
  nlohmann::ordered_json json{{"format", "bipc-verdict"}, {"version", 1}};
  switch (found.outcome) {
    case verify::Outcome::Holds:
      verdict.exit_code = kOk;
      verdict.text = holds_text(image, formula, found);
      if (found.has_errors) verdict.text += kEndsInError;
      json["verdict"] = "holds";
      break;
    case verify::Outcome::Violated:
      verdict.exit_code = kViolated;
      verdict.text = violated_text(image, formula, found);
      json["verdict"] = "violated";
      break;
    case verify::Outcome::Unknown:
      verdict.exit_code = kUnknown;
      verdict.text = "unknown: " + found.reason + '\n';
      if (found.states != 0) verdict.text += "not decided by " + rt::counted(found.states, "reachable state") + '\n';
      json["verdict"] = "unknown";
      break;
  }
  verdict.text += note;
  if (holds && c.system->code.has_cpp()) verdict.text += kCppReturns;
  json["property"] = formula.text;
  if (holds) json["method"] = "branching";
  if (found.states != 0) json["states"] = found.states;
  const bool has_run = found.outcome == verify::Outcome::Violated || (holds && verify::begins_with_possibly(formula));
  if (has_run) {
    json["steps"] = found.choices.size();
    json["choices"] = found.choices;
    if (found.repeats) json["cycle"] = found.cycle;
    nlohmann::ordered_json claims = nlohmann::ordered_json::array();
    for (const verify::ClaimOfBranches& claim : found.claims)
      claims.push_back({{"after", claim.position},
                        {"runs", claim.has_run ? "all" : "none"},
                        {"of_run", claim.of_run},
                        {"states", claim.states}});
    if (!claims.empty()) json["branches"] = claims;
    if (request.wants_run)
      add_run(json, rt::counterexample_json(image, rt::MaximalProgress::On, rt::CounterexampleEnd::State,
                                            rt::at_once(found.choices)));
    FoundRun run{rt::CounterexampleEnd::State, rt::at_once(found.choices), {}, std::nullopt};
    if (found.repeats) run.cycle = found.cycle;
    // While the image has its code.
    if (request.wants_trace)
      run.trace = rt::trace_of_counterexample(image, rt::MaximalProgress::On, found.choices, rt::TraceFormat::Json);
    verdict.counterexample = std::move(run);
  }
  if (found.outcome == verify::Outcome::Unknown) json["reason"] = found.reason;
  json["text"] = verdict.text;
  if (request.stats) {
    verdict.figures += fmt::format("{}, {}; {} of the formula\n", rt::counted(found.states, "state"),
                                   rt::counted(found.steps, "step"), rt::counted(formula.nodes.size(), "node"));
    json["graph"] = {{"states", found.states}, {"steps", found.steps}};
    json["nodes"] = formula.nodes.size();
  }
  verdict.json = std::move(json);
  verdict.is_answered = true;
  return verdict;
}

}  // namespace bip::library
