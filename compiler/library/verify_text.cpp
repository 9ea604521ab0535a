// See verify_text.hpp.
#include "compiler/library/verify_text.hpp"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/library/add_run.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/limits.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/evidence/counterexample_text.hpp"
#include "compiler/verify/portfolio/local_lemma_engine.hpp"
#include "compiler/verify/portfolio/small_instance_engine.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::library {

namespace {

constexpr std::size_t kInvariantsShown = 20, kComponentsShown = 20, kPlacesShown = 8;

std::string count_of(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

const char* found_by_visit(verify::QuestionKind asked) {
  switch (asked) {
    case verify::QuestionKind::DeadlockFreedom: return "no deadlock among";
    case verify::QuestionKind::NoErrors: return "no error among";
    case verify::QuestionKind::NoLocalDeadlock: return "no component waits for ever in";
    case verify::QuestionKind::State: return "true in";
    case verify::QuestionKind::Runs:
    case verify::QuestionKind::Branching: break;
  }
  BIP_UNREACHABLE("a question of no kind");
}

const char* broken_by_state(verify::QuestionKind asked) {
  switch (asked) {
    case verify::QuestionKind::DeadlockFreedom: return "is a deadlock";
    case verify::QuestionKind::NoErrors: return "leads to an error";
    case verify::QuestionKind::NoLocalDeadlock: return "holds a component up for ever";
    case verify::QuestionKind::State:
    case verify::QuestionKind::Runs:
    case verify::QuestionKind::Branching: return "violates it";
  }
  BIP_UNREACHABLE("a question of no kind");
}

// At most kInvariantsShown lines, and how many more there are.
template <class Rows, class Line>
void add_lines(std::string& text, const Rows& rows, const Line& line) {
  for (std::size_t k = 0; k < rows.size() && k < kInvariantsShown; ++k) text += "  " + line(rows[k]) + '\n';
  if (rows.size() > kInvariantsShown) text += fmt::format("  … and {} more\n", rows.size() - kInvariantsShown);
}

// The first line's end, and notes: by what the property was proved.
std::string method_text(const Compilation& c, const verify::Question& question, const verify::Decision& d) {
  const std::string size = fmt::format("({}, {})", count_of(c.system->atoms.size(), "component"),
                                       count_of(c.system->connectors.size(), "connector"));
  const std::string invariants = count_of(d.invariants().size(), "invariant");
  const auto visited = [&] {
    return fmt::format(": {} all {}{}\n", found_by_visit(question.what), count_of(d.states, "reachable state"),
                       d.permuted.empty() ? "" : " up to symmetry");
  };
  return std::visit(
      verify::EvidenceVisitor{
          [&](const verify::InvariantProof&) {
            if (!d.invariants().empty()) return fmt::format(": proved with {} {}\n", invariants, size);
            return fmt::format(": proved without invariants: no combination of the components' own states {} {}\n",
                               broken_by_state(question.what), size);
          },
          [&](const verify::InductiveProof& evidence) {
            const std::size_t equations = d.facts.affine.equations.size();
            const std::string_view engine = d.engine;
            const char* const origin = engine == verify::kSmallInstanceEngine.name ? " learnt from small instances"
                                       : engine == verify::kLocalLemmaEngine.name  ? " about neighbours"
                                                                                   : "";
            return fmt::format(": proved by induction with {}{} and {}{} {}\n", invariants,
                               equations == 0 ? "" : ", " + count_of(equations, "equation"),
                               count_of(evidence.lemmas.size(), "lemma"), origin, size);
          },
          [&](const verify::ReachedStates&) { return visited(); },
          [&](const verify::StateCount& evidence) {
            const bool has_failed = evidence.listing == verify::StateCount::Listing::Impossible;
            return visited() +
                   (has_failed ? "note: the certificate is their number, which only another search can check\n" : "");
          },
          [&](const verify::CountingProof& evidence) {
            return fmt::format(": proved by counting {} with {} {}\n", count_of(evidence.local_states, "local state"),
                               count_of(evidence.sums.size(), "weighted sum"), size);
          },
          [&](const verify::RegionProof& evidence) {
            const std::string neighbourhoods =
                evidence.neighbourhoods == 0 ? "" : " of " + count_of(evidence.neighbourhoods, "neighbourhood");
            return fmt::format(": proved by regions of values: {} with {}{} {}\n",
                               count_of(evidence.local_states, "local state"),
                               count_of(evidence.implications, "implication"), neighbourhoods, size);
          },
          [](const verify::Counterexample&) { return std::string(); },
          [](const std::monostate&) { return std::string(); },
      },
      d.evidence);
}

std::string free_text(const Compilation& c, const verify::Question& question, const verify::Decision& d,
                      const verify::Portfolio& portfolio, Explanation explanation) {
  std::string text = name_of(question.what, Finding::Holds);
  if (question.what == verify::QuestionKind::State) text += fmt::format(": `{}`", question.property.text);
  text += method_text(c, question, d);
  if (explanation == Explanation::None) return text;
  const verify::Net& net = verify::net_of(d, portfolio.net());
  add_lines(text, d.invariants(), [&](const auto& invariant) { return verify::invariant_text(net, invariant); });
  add_lines(text, d.facts.affine.equations,
            [&](const auto& equation) { return verify::equation_text(equation, *c.system); });
  if (const auto* proof = std::get_if<verify::InductiveProof>(&d.evidence)) {
    add_lines(text, proof->lemmas, [&](const verify::Cube& lemma) {
      return "never " + verify::cube_text(*portfolio.transition_system(), *c.system, lemma);
    });
  }
  if (const auto* proof = std::get_if<verify::CountingProof>(&d.evidence)) {
    for (const verify::CountingProof::Sum& sum : proof->sums) {
      text +=
          fmt::format("  a sum that no step raises: at first at most {}, where the property is violated at least {}\n",
                      sum.initially, sum.in_bad_states);
      add_lines(text, sum.weights, [](const std::string& line) { return "  " + line; });
    }
  }
  if (const auto* proof = std::get_if<verify::RegionProof>(&d.evidence)) {
    add_lines(text, proof->reasons, [](const std::string& line) { return line; });
    if (proof->implications > proof->reasons.size()) text += "  …\n";
  }
  return text;
}

std::string unknown_text(const Compilation& c, const verify::Decision& d, const verify::Portfolio& portfolio) {
  std::string text = fmt::format("unknown: {}\n", d.reason);
  const std::vector<verify::u32> candidate = d.open_candidate();
  if (!candidate.empty()) {
    text += "no invariant that was found excludes this state, in which no step is sure:\n";
    for (std::size_t k = 0; k < candidate.size() && k < kComponentsShown; ++k)
      text += "  " + portfolio.net().mode_name(candidate[k]) + '\n';
    if (candidate.size() > kComponentsShown)
      text += fmt::format("  … and {} more\n", candidate.size() - kComponentsShown);
  }
  const verify::TransitionSystem* machine = portfolio.transition_system();
  if (machine != nullptr && !machine->imprecisions.empty()) {
    text += "what is not followed here, and may be anything:\n" +
            verify::imprecision_text(*machine, *c.system, kPlacesShown);
  }
  if (machine != nullptr && machine->lost != verify::kFalse)
    text += fmt::format("more than {} internal transitions in a row are not followed\n", verify::kMaxInternals);
  return text;
}

}  // namespace

const char* name_of(verify::QuestionKind asked, Finding finding) {
  const bool holds = finding == Finding::Holds;
  switch (asked) {
    case verify::QuestionKind::DeadlockFreedom: return holds ? "deadlock-free" : "deadlock";
    case verify::QuestionKind::NoErrors: return holds ? "error-free" : "error";
    case verify::QuestionKind::NoLocalDeadlock: return holds ? "free of local deadlocks" : "local deadlock";
    case verify::QuestionKind::State:
    case verify::QuestionKind::Runs:
    case verify::QuestionKind::Branching: return holds ? "holds" : "violated";
  }
  BIP_UNREACHABLE("a question of no kind");
}

std::string error_note(const std::string& fault) {
  return fmt::format("note: this holds, but a run can end with an error: {}\n", fault);
}

VerdictText verdict_text(const Compilation& c, const verify::Question& question, const verify::Decision& d,
                         const verify::Portfolio& portfolio, Explanation explanation) {
  VerdictText v;
  switch (d.outcome) {
    case verify::Outcome::Holds:
      v = {kOk, name_of(question.what, Finding::Holds), free_text(c, question, d, portfolio, explanation)};
      break;
    case verify::Outcome::Violated:
      BIP_ASSERT(d.counterexample() != nullptr, "a question of kind {} is violated without a run", question.what);
      v = {kViolated, name_of(question.what, Finding::Violated),
           verify::counterexample_text(c.lowered->image, question, *d.counterexample(), kStepsShown)};
      break;
    case verify::Outcome::Unknown: v = {kUnknown, "unknown", unknown_text(c, d, portfolio)}; break;
  }
  if (!d.fault.empty() && d.outcome == verify::Outcome::Holds) v.text += error_note(d.fault);
  if (!d.fault.empty() && d.outcome == verify::Outcome::Unknown)
    v.text += fmt::format("note: a run can end with an error: {}\n", d.fault);
  return v;
}

nlohmann::ordered_json verdict_json(const VerdictText& v, const verify::Question& question, const verify::Decision& d,
                                    const VerifyStats* stats, const std::string& run) {
  nlohmann::ordered_json json{{"format", "bipc-verdict"}, {"version", 1}, {"verdict", v.name}};
  if (question.what == verify::QuestionKind::State) json["property"] = question.property.text;
  if (question.what == verify::QuestionKind::Runs) json["property"] = question.formula.text;
  if (question.what == verify::QuestionKind::Branching) json["property"] = question.branching.text;
  if (question.what == verify::QuestionKind::NoErrors) json["property"] = "errors";
  if (question.what == verify::QuestionKind::NoLocalDeadlock) json["property"] = "partial";
  std::visit(verify::EvidenceVisitor{
                 [&](const verify::InvariantProof&) {
                   json["method"] = "invariants";
                   json["invariants"] = d.invariants().size();
                 },
                 [&](const verify::InductiveProof& evidence) {
                   json["method"] = "induction";
                   json["invariants"] = d.invariants().size();
                   json["lemmas"] = evidence.lemmas.size();
                   if (!d.facts.affine.equations.empty()) json["equations"] = d.facts.affine.equations.size();
                 },
                 [&](const verify::ReachedStates&) { json["method"] = "exhaustive"; },
                 [&](const verify::StateCount&) { json["method"] = "exhaustive"; },
                 [&](const verify::CountingProof& evidence) {
                   json["method"] = "counting";
                   json["local_states"] = evidence.local_states;
                   json["sums"] = evidence.sums.size();
                 },
                 [&](const verify::RegionProof& evidence) {
                   json["method"] = "regions";
                   json["local_states"] = evidence.local_states;
                   json["implications"] = evidence.implications;
                   json["neighbourhoods"] = evidence.neighbourhoods;
                 },
                 [](const verify::Counterexample&) {},
                 [](const std::monostate&) {},
             },
             d.evidence);
  if (d.states != 0) json["states"] = d.states;
  if (!d.permuted.empty()) json["symmetry"] = d.permuted;
  if (const verify::Counterexample* found = d.counterexample()) json["steps"] = found->choices.size();
  if (v.left_out != 0) json["left_out"] = v.left_out;
  if (v.decided && !v.decided->way_out.empty()) {
    json["decided_by"] = v.decided->step;
    json["way_out"] = v.decided->way_out;
  } else if (v.decided) {
    json["inevitable"] = true;
  }
  if (d.outcome == verify::Outcome::Unknown) json["reason"] = d.reason;
  if (stats != nullptr) {
    if (stats->engine != nullptr) json["engine"] = stats->engine;
    json["cpu_seconds"] = stats->seconds;
    json["candidates"] = stats->candidates;
    if (const verify::ProofCache* cache = stats->cache) {
      const verify::ReuseCounts& n = cache->counts;
      json["reuse"] = {{"whole", n.is_whole},
                       {"files", n.files},
                       {"broken", cache->broken_files()},
                       {"known", n.recalled},
                       {"invariants", n.invariants},
                       {"equations", n.equations},
                       {"lemmas", n.lemmas},
                       {"way", n.has_counterexample},
                       {"stored", n.stored}};
    }
  }
  json["text"] = v.text;
  if (!run.empty()) add_run(json, run);
  return json;
}

nlohmann::ordered_json quantifier_json(const verify::Property& property) {
  BIP_ASSERT(property.counted, "`{}` is no quantifier", property.text);
  return {{"conditions", property.counted->rows.size()}, {"asked", property.counted->least}};
}

std::string stats_text(const VerifyStats& stats) {
  const std::string engine = stats.engine == nullptr ? "not decided" : fmt::format("decided by {}", stats.engine);
  std::string text = fmt::format("{} in {:.2f} s of the processor, after {}\n", engine, stats.seconds,
                                 count_of(stats.candidates, "candidate"));
  if (stats.permuted != nullptr && !stats.permuted->empty())
    text += fmt::format("symmetry: states that differ only by a permutation count once; interchangeable are {}\n",
                        fmt::join(*stats.permuted, ", "));
  if (stats.cache == nullptr) return text + "proofs of earlier runs: not used\n";
  const verify::ReuseCounts& n = stats.cache->counts;
  text += fmt::format("proofs of earlier runs: {} in {}", count_of(n.recalled, "row"), count_of(n.files, "file"));
  if (n.recalled != 0) text += fmt::format(" of {}", n.is_whole ? "this system" : "parts of it");
  if (n.recalled != 0)
    text += fmt::format("; checked and used: {}, {}{}{}", count_of(n.invariants, "invariant"),
                        n.equations == 0 ? "" : count_of(n.equations, "equation") + ", ", count_of(n.lemmas, "lemma"),
                        n.has_counterexample ? ", the way" : "");
  if (stats.cache->broken_files() != 0) text += fmt::format("; {} broken", stats.cache->broken_files());
  return text + fmt::format("; {} kept\n", count_of(n.stored, "file"));
}

}  // namespace bip::library
