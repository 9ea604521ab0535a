// See decide.hpp. The engines are those of compiler/verify/portfolio; this is what surrounds them: code, caches, texts.
#include "compiler/library/decide.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "compiler/base/content_cache.hpp"
#include "compiler/library/initial_fault.hpp"
#include "compiler/library/small_instances.hpp"
#include "compiler/library/verify_text.hpp"
#include "compiler/pipeline/cache_folder.hpp"
#include "compiler/pipeline/error_sources.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/machine.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/evidence/proof_cache.hpp"
#include "compiler/verify/net/unread_cpp.hpp"
#include "compiler/verify/evidence/relevant_steps.hpp"
#include "compiler/verify/portfolio/search_bad_state.hpp"
#include "compiler/verify/portfolio/counted_property.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::library {

namespace {

constexpr const char* kSymmetricConditions =
    "note: the components that the quantifier is about are interchangeable: the first ones stand for any\n";

// The note of a verdict that holds: whether a run can end in an error. The same engines decide it, within
// kErrorSeconds.
std::string error_remark(const Compilation& c, const verify::Question& question, const verify::Decision& decision,
                         verify::Portfolio& portfolio, const verify::PortfolioLimits& limits) {
  const bool asked_else =
      question.what == verify::QuestionKind::DeadlockFreedom || question.what == verify::QuestionKind::State;
  // A visit of all states has met the errors.
  if (!asked_else || decision.outcome != verify::Outcome::Holds || verify::is_exhaustive(decision.evidence) ||
      !decision.fault.empty() || !can_end_in_error(*c.system))
    return {};
  verify::Question errors;
  errors.what = verify::QuestionKind::NoErrors;
  verify::PortfolioLimits few;
  few.cancellation = limits.cancellation.within(kErrorSeconds);
  few.threads = limits.threads;
  few.megabytes = limits.megabytes;
  portfolio.use_cache(nullptr);
  const verify::Decision found = portfolio.decide(errors, few);
  switch (found.outcome) {
    case verify::Outcome::Holds: return {};
    case verify::Outcome::Violated:
      return error_note(verify::fault_of(c.lowered->image, found.counterexample()->choices));
    case verify::Outcome::Unknown: return kErrorsNotAsked;
  }
  BIP_UNREACHABLE("an outcome");
}

// Leaves out of a counterexample the steps that it does not need. Returns how many.
std::size_t shorten(verify::Counterexample& found, const Compilation& c, const verify::Question& question,
                    const verify::CancellationToken& token) {
  const std::size_t before = found.choices.size();
  found.choices = verify::relevant_steps(c.lowered->image, verify::goal_of(question), found.choices, token);
  BIP_ASSERT(found.choices.size() <= before, "{} of {} steps are relevant", found.choices.size(), before);
  return before - found.choices.size();
}

// Lines after a counterexample of `steps` steps: what was left out, and which step decided, unless it is the last one.
std::string relevance_text(const VerdictText& said, std::size_t steps) {
  std::string text;
  if (said.left_out != 0)
    text += fmt::format("  left out: {} step{} that this does not need (--all-steps)\n", said.left_out,
                        said.left_out == 1 ? "" : "s");
  if (!said.decided) return text;
  if (said.decided->way_out.empty()) text += "  no choice of these components avoids this\n";
  else if (said.decided->step + 1 != steps)
    text += fmt::format("  decided by #{}: before it, this could be avoided, for example by {}\n", said.decided->step,
                        said.decided->way_out);
  return text;
}

rt::CounterexampleEnd end_of(verify::QuestionKind asked) {
  switch (asked) {
    case verify::QuestionKind::NoErrors: return rt::CounterexampleEnd::Error;
    case verify::QuestionKind::State: return rt::CounterexampleEnd::State;
    case verify::QuestionKind::DeadlockFreedom:
    case verify::QuestionKind::NoLocalDeadlock:
    case verify::QuestionKind::Runs:
    case verify::QuestionKind::Branching: break;
  }
  return rt::CounterexampleEnd::Deadlock;
}

}  // namespace

Result<verify::Question> read_question(const std::string& property, const verify::PropertyReader& reader) {
  Result<verify::ParsedProperty> parsed = reader.read(property);
  if (!parsed) return Failure{parsed.error()};
  verify::Question question;
  switch (parsed->form) {
    case verify::PropertyForm::State: question.what = verify::QuestionKind::State; break;
    case verify::PropertyForm::Runs: question.what = verify::QuestionKind::Runs; break;
    case verify::PropertyForm::Branching: question.what = verify::QuestionKind::Branching; break;
  }
  question.property = std::move(parsed->state);
  question.formula = std::move(parsed->formula);
  question.branching = std::move(parsed->branching);
  question.fairness = std::move(parsed->fairness);
  return question;
}

Result<verify::Question> read_question(const std::string& text, const System& system) {
  verify::Question question;
  if (text.empty() || text == "deadlock") return question;
  if (text == "errors") {
    question.what = verify::QuestionKind::NoErrors;
    return question;
  }
  const auto stated = std::find_if(system.properties.begin(), system.properties.end(),
                                   [&text](const StatedProperty& property) { return property.name == text; });
  return read_question(stated == system.properties.end() ? text : stated->text, verify::PropertyReader(system));
}

Result<verify::Question> read_question(const VerifyRequest& request, const System& system) {
  if (!request.partial) return read_question(request.property, system);
  verify::Question question;
  question.what = verify::QuestionKind::NoLocalDeadlock;
  return question;
}

std::vector<DataRef> data_of(const verify::Question& question) {
  if (question.what == verify::QuestionKind::State) return verify::data_of(question.property);
  std::vector<DataRef> data;
  const std::vector<verify::Property>& conditions =
      question.what == verify::QuestionKind::Branching ? question.branching.states : question.formula.states;
  for (const verify::Property& condition : conditions) {
    const std::vector<DataRef> own = verify::data_of(condition);
    data.insert(data.end(), own.begin(), own.end());
  }
  return data;
}

bool has_undetermined_values(const System& system) { return system.code.has_cpp() || system.code.has_draws(); }

std::string remove_unread_cpp(const VerifyRequest& request, Compilation& c, const std::vector<DataRef>& data) {
  if (!c.system->code.has_cpp() || request.wants_certificate) return {};
  std::optional<System> simple = verify::without_unread_cpp(*c.system, data);
  if (!simple) return {};
  const bool calls = verify::calls_cpp(*c.system);
  c.lowered.reset();
  c.system = std::make_unique<System>(std::move(*simple));
  c.lowered = lower::lower(*c.system, c.root_name);
  return calls ? "note: the model's C++ is taken to return; nothing that it computes decides about a state\n" : "";
}

Verdict plain_verdict(const verify::Question& question, int exit_code, const std::string& name,
                      const std::string& text) {
  verify::Decision none;
  none.outcome = verify::Outcome::Violated;
  Verdict verdict;
  verdict.is_answered = true;
  verdict.exit_code = exit_code;
  verdict.text = text;
  verdict.json = verdict_json({exit_code, name, text}, question, none, nullptr);
  return verdict;
}

Verdict refuse(const VerifyRequest& request, Compilation& c, const verify::Question& question,
               const Unsupported& unsupported) {
  if (!request.is_one_of_many) {
    c.diags.report(Diag::kB1900, c.root_range, unsupported.what).note(unsupported.note).help(unsupported.help);
    return {};
  }
  verify::Decision none;
  none.reason = unsupported.what + " is not supported yet";
  Verdict verdict;
  verdict.is_answered = true;
  verdict.exit_code = kUnknown;
  verdict.text = fmt::format("unknown: {}\nnote: {}\nhelp: {}\n", none.reason, unsupported.note, unsupported.help);
  verdict.json = verdict_json({kUnknown, "unknown", verdict.text}, question, none, nullptr);
  return verdict;
}

std::optional<Verdict> decide_initial_fault(const Compilation& c, const verify::Question& question) {
  if (has_undetermined_values(*c.system) || question.what == verify::QuestionKind::NoErrors) return std::nullopt;
  const std::string fault = initial_fault(*c.system);
  if (fault.empty()) return std::nullopt;
  return plain_verdict(question, kModelErrors, "no-state", fmt::format("no run reaches a state: {}\n", fault));
}

Verdict decide(const VerifyRequest& request, Compilation& c, const verify::Question& question, const std::string& note,
               const verify::CancellationToken& asked, const verify::Report& report) {
  if (question.fairness) {
    // What the property says takes the place of what is said beside it.
    VerifyRequest fair = request;
    fair.fairness = *question.fairness;
    verify::Question rest = question;
    rest.fairness.reset();
    return decide(fair, c, rest, note, asked, report);
  }
  const verify::CancellationToken token =
      request.wall_timeout > 0 ? asked.within_wall_clock(request.wall_timeout) : asked;
  const bool is_timed = system::is_timed(*c.system);
  if (question.what == verify::QuestionKind::State && !request.wants_certificate) {
    if (std::optional<verify::Property> fewer = verify::with_first_conditions(question.property, c.lowered->image)) {
      verify::Question about_fewer = question;
      about_fewer.property = std::move(*fewer);
      Verdict verdict = decide(request, c, about_fewer, note + kSymmetricConditions, asked, report);
      if (verdict.is_answered) verdict.json["quantifier"] = quantifier_json(question.property);
      return verdict;
    }
  }
  if (question.formula.has_limit() || (is_timed && question.formula.response))
    return decide_response(request, c, question, note, token);
  if (is_timed && question.what == verify::QuestionKind::Runs && verify::is_invariant_of_past(question.formula))
    return decide_timed_past(request, c, question, note, token);
  if (question.what == verify::QuestionKind::Branching) {
    if (std::optional<Verdict> verdict = decide_possible(request, c, question, note, token, report))
      return std::move(*verdict);
    return decide_branching(request, c, question, note, token, report);
  }
  if (question.what == verify::QuestionKind::Runs) return decide_liveness(request, c, question, note, token, report);
  if (is_timed) return decide_timed(request, c, question, note, token);
  verify::PortfolioLimits limits;
  limits.cancellation = token.within(request.timeout);
  limits.threads = processors();
  limits.megabytes = static_cast<std::size_t>(request.megabytes);
  limits.wants_certificate = request.wants_certificate;
  limits.wants_minimal_proof = limits.wants_certificate || request.why;
  Executor executor(MachineCode::Fresh);
  bool is_ready = true;
  const auto prepare = [&] {
    is_ready = executor.prepare(c, request.backend, Optimisation::Auto);
    return is_ready;
  };
  const CacheOptions& kept = c.options.cache;
  ContentCache cache(ContentKind::Proof, cache_folder(kept).string(), kept.megabytes << 20);
  verify::ProofCache proofs(cache, cache_version());
  const verify::StateAccess access =
      has_undetermined_values(*c.system) ? verify::StateAccess::Undetermined : verify::StateAccess::Searchable;
  verify::Portfolio portfolio(*c.system, c.lowered->image, access, prepare, report);
  if (request.reuses && cache.is_on()) portfolio.use_cache(&proofs);
  SmallInstanceCompiler smaller(c);
  const verify::SmallInstances instances = [&](std::uint32_t size) { return smaller.at(size); };
  portfolio.use_small_instances(&instances);
  const verify::ProcessClock::time_point start = verify::ProcessClock::now();
  verify::Decision decision = portfolio.decide(question, limits);
  const double seconds = std::chrono::duration<double>(verify::ProcessClock::now() - start).count();
  Verdict verdict;
  if (!is_ready) return verdict;
  verdict.is_answered = true;
  auto* const broken_by = std::get_if<verify::Counterexample>(&decision.evidence);
  const bool is_replayable = broken_by != nullptr && question.what != verify::QuestionKind::NoLocalDeadlock &&
                             !has_undetermined_values(*c.system);
  const std::size_t left_out =
      is_replayable && !request.all_steps ? shorten(*broken_by, c, question, token) : std::size_t{0};
  VerdictText said =
      verdict_text(c, question, decision, portfolio, request.why ? Explanation::Evidence : Explanation::None);
  said.left_out = left_out;
  if (is_replayable) {
    said.decided = verify::deciding_step(c.lowered->image, verify::goal_of(question), broken_by->choices, token);
    BIP_ASSERT(!said.decided || said.decided->way_out.empty() || said.decided->step < broken_by->choices.size(),
               "step {} of {} decided", said.decided->step, broken_by->choices.size());
    said.text += relevance_text(said, broken_by->choices.size());
  }
  said.text += note;
  if (decision.outcome == verify::Outcome::Holds && c.system->code.has_cpp()) said.text += kCppReturns;
  if (request.wants_certificate && decision.outcome == verify::Outcome::Holds)
    verdict.certificate = verify::certificate(portfolio, question, decision, *c.system, c.root_name);
  said.text += error_remark(c, question, decision, portfolio, limits);
  const VerifyStats stats{decision.engine, seconds, decision.candidates(),
                          request.reuses && cache.is_on() ? &proofs : nullptr, &decision.permuted};
  const VerifyStats* shown = request.stats ? &stats : nullptr;
  verdict.exit_code = said.exit_code;
  std::string run_data;
  if (const verify::Counterexample* found = decision.counterexample(); found != nullptr && request.wants_run)
    run_data = rt::counterexample_json(c.lowered->image, rt::MaximalProgress::On, end_of(question.what),
                                       rt::at_once(found->choices));
  verdict.json = verdict_json(said, question, decision, shown, run_data);
  verdict.text = std::move(said.text);
  if (shown != nullptr) verdict.figures = stats_text(stats);
  if (const verify::Counterexample* found = decision.counterexample()) {
    FoundRun run{end_of(question.what), rt::at_once(found->choices), {}};
    // While the image has its code.
    if (request.wants_trace)
      run.trace =
          rt::trace_of_counterexample(c.lowered->image, rt::MaximalProgress::On, found->choices, rt::TraceFormat::Json);
    verdict.counterexample = std::move(run);
  }
  return verdict;
}

}  // namespace bip::library
