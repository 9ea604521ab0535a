// Verdicts about properties of runs: see decide.hpp. What the graph of states cannot treat is refused by name or
// unknown with the reason.
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/library/decide.hpp"
#include "compiler/library/add_run.hpp"
#include "compiler/library/run_text.hpp"
#include "compiler/library/verify_text.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/limits.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
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

// False: there is none, which was said.
bool add_certificate(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                     const verify::StateCollector& reached, const std::optional<verify::KLivenessProof>& proof,
                     Verdict& verdict) {
  const std::string rows = proof ? proof->rows : reached.rows();
  const auto refuse = [&](const std::string& what) {
    c.diags.report(Diag::kB1900, c.root_range, "a certificate for a property of runs " + what)
        .help("without `--certificate` the property is decided");
    return false;
  };
  if (!proof && !reached.is_listable())
    return refuse("of a model with floats, C++ data or priorities below connectors");
  if (rows.empty()) return refuse("whose states are too many for `--memory`");
  const std::optional<std::string> text =
      verify::certificate_of_runs(question.formula, request.fairness, rows, *c.system, c.root_name);
  if (!text) return refuse("that repeats its parts too often");
  verdict.certificate = *text;
  return true;
}

constexpr const char* kErrorsNotLookedAt = "note: runs that end in a run-time error were not looked at\n";

// Each thing with a name of which fairness is asked: "  fair to `p.enter` (strong): it happens in #4".
template <class Line>
void each_turn(const verify::Fairness& fairness, const verify::LivenessResult& found, const Line& line) {
  std::size_t row = 0;
  for (const verify::FairnessTerm& term : fairness.terms) {
    if (term.has_name() && row < found.turns.size()) line(term, found.turns[row++]);
  }
}
constexpr std::size_t kTurnsShown = 8;

std::string turns_text(const verify::Fairness& fairness, const verify::LivenessResult& found) {
  std::string text;
  std::size_t shown = 0;
  each_turn(fairness, found, [&](const verify::FairnessTerm& term, const verify::FairTurn& turn) {
    if (++shown > kTurnsShown) return;
    const bool is_component = term.unit == verify::FairnessUnit::Atom;
    text += fmt::format("  fair to `{}` ({}): it ", term.path, term.is_strong() ? "strong" : "weak");
    switch (turn.why) {
      case verify::FairTurn::Why::Happens:
        text += fmt::format("{} #{}\n", is_component ? "takes part in" : "happens in", turn.step);
        break;
      case verify::FairTurn::Why::Impossible:
        text +=
            fmt::format("{} before #{}\n", is_component ? "can take part in nothing" : "is not possible", turn.step);
        break;
      case verify::FairTurn::Why::NeverPossible:
        text += is_component ? "can take part in nothing in the states that repeat\n"
                             : "is possible in no state that repeats\n";
        break;
    }
  });
  if (shown > kTurnsShown) text += fmt::format("  … and to {} more\n", shown - kTurnsShown);
  return text;
}

nlohmann::ordered_json turns_json(const verify::Fairness& fairness, const verify::LivenessResult& found) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  each_turn(fairness, found, [&](const verify::FairnessTerm& term, const verify::FairTurn& turn) {
    using Why = verify::FairTurn::Why;
    nlohmann::ordered_json row{{"of", term.path},
                               {"fairness", term.is_strong() ? "strong" : "weak"},
                               {"why", turn.why == Why::Happens      ? "happens"
                                       : turn.why == Why::Impossible ? "impossible"
                                                                     : "never possible"}};
    if (turn.why != Why::NeverPossible) row["step"] = turn.step;
    rows.push_back(std::move(row));
  });
  return rows;
}

// What the property reads of the state in which the run violates it.
std::string last_state_text(const rt::Image& image, const verify::Question& question,
                            const verify::LivenessResult& found) {
  rt::Core core(image);
  bool is_sound = core.initialize();
  for (std::size_t at = 0; at < found.choices.size() && is_sound; ++at) is_sound = core.fire(found.choices[at]);
  return is_sound ? verify::atoms_text(core, verify::atoms_of(question.formula.states)) : std::string();
}

std::string violated_text(const rt::Image& image, const verify::Question& question, const VerifyRequest& request,
                          const verify::LivenessResult& found) {
  const bool has_ended = found.cycle == found.choices.size() && (!found.is_prefix || found.has_ended);
  BIP_ASSERT(found.cycle <= found.choices.size(), "the cycle begins with step {} of {}", found.cycle,
             found.choices.size());
  std::string text = steps_text(image, {found.choices, found.cycle, has_ended}, kStepsShown);
  if (found.is_prefix)
    return text +
           fmt::format("violated[V0005]: `{}`   ({})\n", question.formula.text,
                       rt::counted(found.choices.size(), "step")) +
           last_state_text(image, question, found);
  text += fmt::format("violated[V0005]: `{}`   ({}; {})\n", question.formula.text,
                      rt::counted(found.choices.size(), "step"), verify::words_of(request.fairness));
  text += turns_text(request.fairness, found);
  if (found.holds_under)
    text += fmt::format("note: it holds under {} (`--fair={}`)\n", verify::words_of(*found.holds_under),
                        verify::name_of(*found.holds_under));
  return text;
}

// What the circuit showed, and of how much of the system.
std::string proof_text(const verify::Question& question, const VerifyRequest& request,
                       const verify::KLivenessProof& proof, std::size_t atoms) {
  const std::string part = proof.atoms == atoms ? rt::counted(atoms, "component")
                                                : fmt::format("{} of {}", proof.atoms, rt::counted(atoms, "component"));
  const std::string rest =
      proof.finite_ports == 0 ? "" : fmt::format(" once {} have come to rest", rt::counted(proof.finite_ports, "port"));
  std::string text =
      verify::is_invariant_of_past(question.formula)
          ? fmt::format("holds: `{}`: true at each point of all runs, by IC3 on {}\n", question.formula.text, part)
          : fmt::format("holds: `{}`: true of all runs, by k-liveness: at most {} on {}{} ({})\n",
                        question.formula.text, rt::counted(proof.rounds, "round"), part, rest,
                        verify::words_of(request.fairness));
  if (proof.may_have_errors) text += kErrorsNotLookedAt;
  return text;
}

std::string neighbourhood_text(const verify::Question& question, const VerifyRequest& request,
                               const verify::NeighbourhoodProof& proof) {
  const std::string rest = proof.needs_endless_runs ? ", and no run ends" : "";
  const std::string by = proof.neighbours == 0
                             ? "the components that it names alone"
                             : fmt::format("{} and at most {} beside", rt::counted(proof.cases, "case"),
                                           rt::counted(proof.neighbours, "component"));
  std::string text = fmt::format("holds: `{}`: true of all runs, by {}{} ({})\n", question.formula.text, by, rest,
                                 verify::words_of(request.fairness));
  if (proof.may_have_errors) text += kErrorsNotLookedAt;
  return text;
}

}  // namespace

Verdict decide_liveness(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                        const std::string& note, const verify::CancellationToken& token, const verify::Report& report) {
  if (const std::string what = system::first_timed(*c.system); !what.empty())
    return refuse(
        request, c, question,
        {"this property of runs for a model with time", what,
         "`eventually E`, `always eventually E` and `E leads to F` have answers, E and F without words of time, and "
         "so has `always E` where E looks back"});
  Verdict verdict;
  Executor executor(MachineCode::Fresh);
  const bool has_graph = !has_undetermined_values(*c.system);
  if (has_graph && !executor.prepare(c, request.backend, Optimisation::Auto)) return verdict;
  verify::LivenessOptions options;
  options.fairness = request.fairness;
  options.megabytes = static_cast<std::size_t>(request.megabytes);
  options.cancellation = token.within(request.timeout);
  verify::StateCollector reached(*c.system, c.lowered->image, request.megabytes * (kMega / 2));
  if (request.wants_certificate) options.add_state = [&](const rt::Core& core) { reached.add(core.snapshot()); };
  else if (has_graph) options.unread_cells = verify::find_unread_cells(*c.system, c.lowered->image, data_of(question));
  options.report = report;
  const verify::RunsDecision decision =
      verify::decide_runs(question.formula, *c.system, c.lowered->image,
                          has_graph ? verify::StateAccess::Searchable : verify::StateAccess::Undetermined, options);
  const verify::LivenessResult& found = decision.on_graph;
  if (request.wants_certificate && decision.outcome == verify::Outcome::Holds &&
      !add_certificate(request, c, question, reached, decision.proof, verdict))
    return verdict;
  // Null as well for what is true of any run.
  const verify::KLivenessProof* proof = decision.proof && decision.proof->atoms != 0 ? &*decision.proof : nullptr;
  const std::optional<verify::NeighbourhoodProof>& around = decision.by_neighbourhoods;
  nlohmann::ordered_json json{{"format", "bipc-verdict"}, {"version", 1}};
  const std::string states = rt::counted(found.states, "reachable state");
  // Finite runs decide it, so fairness does not matter.
  const bool is_invariant = verify::is_invariant_of_past(question.formula);
  switch (decision.outcome) {
    case verify::Outcome::Holds:
      verdict.exit_code = kOk;
      verdict.text =
          around              ? neighbourhood_text(question, request, *around)
          : proof != nullptr  ? proof_text(question, request, *proof, c.system->atoms.size())
          : found.states == 0 ? fmt::format("holds: `{}`: true of any run of any model\n", question.formula.text)
          : is_invariant
              ? fmt::format("holds: `{}`: true at each point of all runs through {}\n", question.formula.text, states)
              : fmt::format("holds: `{}`: true of all runs through {} ({})\n", question.formula.text, states,
                            verify::words_of(request.fairness));
      if (found.has_errors && proof == nullptr && !around) verdict.text += kEndsInError;
      json["verdict"] = "holds";
      break;
    case verify::Outcome::Violated:
      verdict.exit_code = kViolated;
      verdict.text = violated_text(c.lowered->image, question, request, found);
      json["verdict"] = "violated";
      break;
    case verify::Outcome::Unknown:
      verdict.exit_code = kUnknown;
      verdict.text = "unknown: " + decision.reason + '\n';
      if (found.states != 0) verdict.text += "no violation among the runs through " + states + '\n';
      json["verdict"] = "unknown";
      break;
  }
  verdict.text += note;
  if (decision.outcome == verify::Outcome::Holds && c.system->code.has_cpp()) verdict.text += kCppReturns;
  json["property"] = question.formula.text;
  if (!is_invariant) json["fairness"] = verify::name_of(request.fairness);
  if (decision.outcome == verify::Outcome::Holds)
    json["method"] = around ? "neighbourhoods" : proof != nullptr ? "k-liveness" : "runs";
  if (around) {
    json["cases"] = around->cases;
    json["neighbours"] = around->neighbours;
  }
  if (proof != nullptr) {
    if (!is_invariant) json["rounds"] = proof->rounds;
    json["components"] = proof->atoms;
    if (proof->finite_ports != 0) json["finite_ports"] = proof->finite_ports;
  }
  // Of a proof on the circuit no states are known.
  if (found.states != 0 && proof == nullptr && !around) json["states"] = found.states;
  if (decision.outcome == verify::Outcome::Violated) {
    json["steps"] = found.choices.size();
    json["choices"] = found.choices;
    if (!found.is_prefix) json["cycle"] = found.cycle;
    if (!found.turns.empty()) json["fair_to"] = turns_json(request.fairness, found);
    if (found.holds_under) json["holds_under"] = verify::name_of(*found.holds_under);
    if (request.wants_run)
      add_run(json, rt::counterexample_json(c.lowered->image, rt::MaximalProgress::On, rt::CounterexampleEnd::State,
                                            rt::at_once(found.choices)));
    FoundRun run{rt::CounterexampleEnd::State, rt::at_once(found.choices), {}, std::nullopt};
    if (!found.is_prefix) run.cycle = found.cycle;
    // While the image has its code.
    if (request.wants_trace)
      run.trace =
          rt::trace_of_counterexample(c.lowered->image, rt::MaximalProgress::On, found.choices, rt::TraceFormat::Json);
    verdict.counterexample = std::move(run);
  }
  if (decision.outcome == verify::Outcome::Unknown) json["reason"] = decision.reason;
  json["text"] = verdict.text;
  if (request.stats) {
    verdict.figures += fmt::format("{}, {}; automaton of {}, product of {}\n", rt::counted(found.states, "state"),
                                   rt::counted(found.steps, "step"), rt::counted(found.automaton_states, "state"),
                                   rt::counted(found.nodes, "node"));
    json["graph"] = {{"states", found.states}, {"steps", found.steps}};
    json["automaton"] = found.automaton_states;
    json["product"] = found.nodes;
    if (proof != nullptr) {
      verdict.figures += fmt::format("{} in {}; {} of fairness\n", rt::counted(proof->lemmas, "lemma"),
                                     rt::counted(proof->frames, "frame"), rt::counted(proof->units, "unit"));
      json["lemmas"] = proof->lemmas;
      json["frames"] = proof->frames;
    }
  }
  verdict.json = std::move(json);
  verdict.is_answered = true;
  return verdict;
}

}  // namespace bip::library
