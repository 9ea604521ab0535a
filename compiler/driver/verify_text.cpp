// See verify_text.hpp.
#include "compiler/driver/verify_text.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/driver/exit_codes.hpp"
#include "compiler/driver/terminal.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/evidence/counterexample_text.hpp"

namespace bip::driver {

namespace {

constexpr std::size_t kInvariantsShown = 20, kComponentsShown = 20, kPlacesShown = 8;

std::string count_of(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

const char* name_of(verify::QuestionKind asked, bool holds) {
  switch (asked) {
    case verify::QuestionKind::DeadlockFreedom: return holds ? "deadlock-free" : "deadlock";
    case verify::QuestionKind::NoErrors: return holds ? "error-free" : "error";
    case verify::QuestionKind::NoLocalDeadlock: return holds ? "free of local deadlocks" : "local deadlock";
    default: return holds ? "holds" : "violated";
  }
}

const char* found_by_visit(verify::QuestionKind asked) {
  switch (asked) {
    case verify::QuestionKind::DeadlockFreedom: return "no deadlock among";
    case verify::QuestionKind::NoErrors: return "no error among";
    case verify::QuestionKind::NoLocalDeadlock: return "no component waits for ever in";
    default: return "true in";
  }
}

bool has_invariants(const System& system) {
  return std::any_of(system.atoms.begin(), system.atoms.end(),
                     [&](const Atom& atom) { return !system.atom_types[atom.type].invariants.empty(); });
}

std::string free_text(const Compilation& c, const verify::Question& question, const verify::Decision& d,
                      const verify::Portfolio& decider, bool why) {
  std::string text = name_of(question.what, true);
  if (question.what == verify::QuestionKind::State) text += fmt::format(": `{}`", question.property.text);
  const std::string size = fmt::format("({}, {})", count_of(c.system->atoms.size(), "component"),
                                       count_of(c.system->connectors.size(), "connector"));
  if (d.method == verify::Method::Exhaustive) {
    text += fmt::format(": {} all {}\n", found_by_visit(question.what), count_of(d.states, "reachable state"));
    if (d.is_only_counted) text += "note: the certificate is their number, which only another search can check\n";
  } else if (d.method == verify::Method::Invariants) {
    text += fmt::format(": proved with {} {}\n", count_of(d.proof.invariants.size(), "invariant"), size);
  } else {
    const std::string equations =
        d.linear.equations.empty() ? "" : ", " + count_of(d.linear.equations.size(), "equation");
    text += fmt::format(": proved by induction with {}{} and {} {}\n", count_of(d.proof.invariants.size(), "invariant"),
                        equations, count_of(d.lemmas.size(), "lemma"), size);
  }
  if (!why) return text;
  for (std::size_t k = 0; k < d.proof.invariants.size() && k < kInvariantsShown; ++k) {
    text += "  " + verify::invariant_text(decider.net(), d.proof.invariants[k]) + '\n';
  }
  if (d.proof.invariants.size() > kInvariantsShown)
    text += fmt::format("  … and {} more\n", d.proof.invariants.size() - kInvariantsShown);
  for (std::size_t k = 0; k < d.linear.equations.size() && k < kInvariantsShown; ++k)
    text += "  " + verify::equation_text(d.linear.equations[k], *c.system) + '\n';
  if (d.linear.equations.size() > kInvariantsShown)
    text += fmt::format("  … and {} more\n", d.linear.equations.size() - kInvariantsShown);
  for (std::size_t k = 0; k < d.lemmas.size() && k < kInvariantsShown; ++k) {
    text += "  never " + verify::cube_text(*decider.machine(), *c.system, d.lemmas[k]) + '\n';
  }
  if (d.lemmas.size() > kInvariantsShown) text += fmt::format("  … and {} more\n", d.lemmas.size() - kInvariantsShown);
  return text;
}

std::string unknown_text(const Compilation& c, const verify::Decision& d, const verify::Portfolio& decider) {
  std::string text = fmt::format("unknown: {}\n", d.reason);
  const std::vector<verify::u32>& candidate = d.proof.candidate;
  if (!candidate.empty()) {
    text += "no invariant that was found excludes this state, in which no step is sure:\n";
    for (std::size_t k = 0; k < candidate.size() && k < kComponentsShown; ++k)
      text += "  " + decider.net().mode_name(candidate[k]) + '\n';
    if (candidate.size() > kComponentsShown)
      text += fmt::format("  … and {} more\n", candidate.size() - kComponentsShown);
  }
  if (decider.machine() != nullptr && !decider.machine()->imprecisions.empty()) {
    text += "what is not followed here, and may be anything:\n" +
            verify::imprecision_text(*decider.machine(), *c.system, kPlacesShown);
  }
  return text;
}

}  // namespace

VerdictText verdict_text(const Compilation& c, const verify::Question& question, const verify::Decision& d,
                         const verify::Portfolio& decider, bool why) {
  VerdictText v;
  switch (d.outcome) {
    case verify::Outcome::Holds:
      v = {kOk, name_of(question.what, true), free_text(c, question, d, decider, why)};
      break;
    case verify::Outcome::Violated:
      v = {kViolated, name_of(question.what, false),
           verify::counterexample_text(c.lowered->image, question, d, kStepsShown)};
      break;
    case verify::Outcome::Unknown: v = {kUnknown, "unknown", unknown_text(c, d, decider)}; break;
  }
  if (!d.fault.empty() && d.outcome != verify::Outcome::Violated)
    v.text += fmt::format("note: a run-time error can occur: {}\n", d.fault);
  // Who visited all states has seen whether they hold.
  const bool asked_else =
      question.what == verify::QuestionKind::DeadlockFreedom || question.what == verify::QuestionKind::State;
  if (asked_else && d.outcome == verify::Outcome::Holds && d.method != verify::Method::Exhaustive &&
      has_invariants(*c.system)) {
    v.text += "note: the model's own invariants were not asked for: `--property errors` does\n";
  }
  return v;
}

std::string verdict_json(const VerdictText& v, const verify::Question& question, const verify::Decision& d,
                         const VerifyStats* stats) {
  nlohmann::ordered_json json{{"format", "bipc-verdict"}, {"version", 1}, {"verdict", v.name}};
  if (question.what == verify::QuestionKind::State) json["property"] = question.property.text;
  if (question.what == verify::QuestionKind::NoErrors) json["property"] = "errors";
  if (question.what == verify::QuestionKind::NoLocalDeadlock) json["property"] = "partial";
  if (d.outcome == verify::Outcome::Holds) {
    json["method"] = d.method == verify::Method::Exhaustive  ? "exhaustive"
                     : d.method == verify::Method::Induction ? "induction"
                                                             : "invariants";
    if (d.method != verify::Method::Exhaustive) json["invariants"] = d.proof.invariants.size();
    if (d.method == verify::Method::Induction) json["lemmas"] = d.lemmas.size();
    if (d.method == verify::Method::Induction && !d.linear.equations.empty())
      json["equations"] = d.linear.equations.size();
  }
  if (d.states != 0) json["states"] = d.states;
  if (d.outcome == verify::Outcome::Violated) json["steps"] = d.choices.size();
  if (d.outcome == verify::Outcome::Unknown) json["reason"] = d.reason;
  if (stats != nullptr) {
    json["cpu_seconds"] = stats->seconds;
    json["candidates"] = stats->candidates;
    if (const verify::ProofCache* memory = stats->memory) {
      const verify::ReuseCounts& n = memory->counts;
      json["reuse"] = {{"whole", n.is_whole}, {"files", n.files},           {"broken", memory->broken_files()},
                       {"known", n.recalled}, {"invariants", n.invariants}, {"equations", n.equations},
                       {"lemmas", n.lemmas},  {"way", n.has_way},           {"stored", n.stored}};
    }
  }
  json["text"] = v.text;
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

std::string stats_text(const VerifyStats& stats) {
  std::string text = fmt::format("decided in {:.2f} s of the processor, after {}\n", stats.seconds,
                                 count_of(stats.candidates, "candidate"));
  if (stats.memory == nullptr) return text + "proofs of earlier runs: not used\n";
  const verify::ReuseCounts& n = stats.memory->counts;
  text += fmt::format("proofs of earlier runs: {} in {}", count_of(n.recalled, "row"), count_of(n.files, "file"));
  if (n.recalled != 0) text += fmt::format(" of {}", n.is_whole ? "this system" : "parts of it");
  if (n.recalled != 0)
    text += fmt::format("; checked and used: {}, {}{}{}", count_of(n.invariants, "invariant"),
                        n.equations == 0 ? "" : count_of(n.equations, "equation") + ", ", count_of(n.lemmas, "lemma"),
                        n.has_way ? ", the way" : "");
  if (stats.memory->broken_files() != 0) text += fmt::format("; {} broken", stats.memory->broken_files());
  return text + fmt::format("; {} kept\n", count_of(n.stored, "file"));
}

}  // namespace bip::driver
