// Verdicts about `possibly E` and other properties that negate one of all runs: see decide.hpp. The negation is asked,
// with its own engines, and the answer turned round.
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/library/decide.hpp"
#include "compiler/library/run_text.hpp"
#include "compiler/library/timed_verdict.hpp"
#include "compiler/library/verify_text.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/limits.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/evidence/counterexample_text.hpp"
#include "runtime/core/text.hpp"
#include "runtime/explore/counterexample.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::library {

namespace {

// Which states can be reached no fairness changes: each finite run has a fair continuation.
bool is_decided_by_negation(const VerifyRequest& request, const System& system, const verify::Question& negation) {
  const bool is_timed = system::is_timed(system);
  switch (negation.what) {
    case verify::QuestionKind::State: return true;
    // Without fairness, the graph of branching time says more about states in which each step ends in an error.
    case verify::QuestionKind::Runs:
      return is_timed ? negation.formula.response.has_value() : !request.fairness.is_none();
    case verify::QuestionKind::DeadlockFreedom:
    case verify::QuestionKind::NoErrors:
    case verify::QuestionKind::NoLocalDeadlock:
    case verify::QuestionKind::Branching: return false;
  }
  BIP_UNREACHABLE("a question of no kind");
}

std::vector<std::uint64_t> choices_of(const rt::TimedPath& path) {
  std::vector<std::uint64_t> choices;
  for (const rt::TimedStep& step : path.steps) choices.push_back(step.choice);
  return choices;
}

// What the property reads of the state that the run reaches.
std::string last_state_text(const rt::Image& image, const verify::BranchingFormula& formula, const FoundRun& run) {
  rt::Core core(image);
  const auto ignore = [](std::uint64_t, std::uint64_t) {};
  if (rt::follow_path(core, run.end, run.path, ignore, [] {}) != run.path.steps.size() || core.fault()) return {};
  return verify::atoms_text(core, verify::atoms_of(formula.states));
}

// The steps, what they show, and of it what the property is about. `json`: the answer about the negation.
std::string shown_text(const Compilation& c, const verify::BranchingFormula& formula, const FoundRun& run,
                       const nlohmann::ordered_json& json, const VerifyRequest& request,
                       verify::QuestionKind negation) {
  const rt::Image& image = c.lowered->image;
  const bool is_timed = system::is_timed(*c.system);
  const std::size_t steps = run.path.steps.size();
  std::string at;
  if (is_timed) {
    at = ", at ";
    rt::append_time(at, run.path.end);
  }
  const std::uint64_t states = json.value("states", std::uint64_t{0});
  if (states != 0) at += fmt::format("; {} visited", rt::counted(states, "reachable state"));
  const bool is_of_state = negation == verify::QuestionKind::State;
  if (!is_of_state && !request.fairness.is_none())
    at += fmt::format("; it is fair, --fair={}", verify::name_of(request.fairness));
  const std::string conclusion =
      fmt::format("holds: `{}`: this run shows it ({}{})\n", formula.text, rt::counted(steps, "step"), at);
  if (!is_timed && run.cycle) {
    const bool has_ended = *run.cycle == steps;
    return steps_text(image, {choices_of(run.path), *run.cycle, has_ended}, kStepsShown) + conclusion;
  }
  std::string text =
      rt::describe_counterexample(image, rt::MaximalProgress::On, run.end, run.path, kStepsShown).steps + conclusion;
  if (is_of_state) text += last_state_text(image, formula, run);
  else if (is_timed) text += "  " + endless_text(run.end, steps, run.cycle) + '\n';
  if (const std::size_t left_out = json.value("left_out", std::size_t{0}); left_out != 0)
    text += fmt::format("  left out: {} that this does not need (--all-steps)\n", rt::counted(left_out, "step"));
  return text;
}

// "  no run from the initial state reaches `a@B`; `never (a@B)` holds: proved with 3 invariants …"
std::string excluded_text(const verify::BranchingFormula& formula, const verify::BranchingNode& root,
                          const std::string& proof) {
  const std::string first = fmt::format("holds: `{}`", formula.negation);
  BIP_ASSERT(proof.starts_with(first), "a proof of `{}` that says: {}", formula.negation, proof);
  return fmt::format("violated[V0007]: `{}`   (0 steps)\n  no run from the initial state {}; `{}` holds{}",
                     formula.text, root.of_run, formula.negation, proof.substr(first.size()));
}

}  // namespace

std::optional<Verdict> decide_possible(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                                       const std::string& note, const verify::CancellationToken& token,
                                       const verify::Report& report) {
  const verify::BranchingFormula& formula = question.branching;
  if (formula.negation.empty()) return std::nullopt;
  Result<verify::Question> negation = read_question(formula.negation, verify::PropertyReader(*c.system));
  BIP_ENSURE(negation, "`{}` was read as `{}`: {}", formula.text, formula.negation, negation.error());
  // It would violate `never E` and show nothing of `possibly E`.
  BIP_ASSERT(negation->property.fault == verify::Property::kNoRow, "a division in `{}` can fail", formula.text);
  if (!is_decided_by_negation(request, *c.system, *negation)) return std::nullopt;
  Verdict verdict = decide(request, c, *negation, {}, token, report);
  if (!verdict.is_answered) return verdict;
  const nlohmann::ordered_json answer = std::move(verdict.json);
  nlohmann::ordered_json json{{"format", "bipc-verdict"},
                              {"version", 1},
                              {"verdict", answer.value("verdict", "")},
                              {"property", formula.text},
                              {"negation", formula.negation}};
  if (verdict.exit_code == kViolated) json["method"] = "run";
  for (const auto& [key, value] : answer.items()) {
    if (!json.contains(key)) json[key] = value;
  }
  switch (verdict.exit_code) {
    case kViolated: {
      if (request.wants_certificate) {
        // Those of the graph list all states, without time.
        if (negation->what == verify::QuestionKind::State && !system::is_timed(*c.system)) return std::nullopt;
        return refuse(request, c, question,
                      {"a certificate for a property that a run shows",
                       "the run leads there with these steps of the core", "`--trace` writes the run"});
      }
      BIP_ASSERT(verdict.counterexample, "`{}` is violated without a run", formula.negation);
      Executor executor(MachineCode::Fresh);
      if (!executor.prepare(c, Backend::Interp, Optimisation::Auto)) return Verdict();
      const FoundRun& run = *verdict.counterexample;
      verdict.exit_code = kOk;
      verdict.text = shown_text(c, formula, run, answer, request, negation->what);
      json["verdict"] = "holds";
      if (!system::is_timed(*c.system)) json["choices"] = choices_of(run.path);
      // Of a violation: which step decided that it comes.
      for (const char* key : {"decided_by", "way_out", "inevitable", "holds_under"}) json.erase(key);
      break;
    }
    case kOk:
      verdict.exit_code = kViolated;
      verdict.text = excluded_text(formula, formula.nodes[formula.root], verdict.text);
      json["verdict"] = "violated";
      break;
    default: break;
  }
  verdict.text += note;
  json["text"] = verdict.text;
  verdict.json = std::move(json);
  return verdict;
}

}  // namespace bip::library
