// `bipc verify`: decides deadlock-freedom, run-time errors or a property of states
// (compiler/verify/portfolio/portfolio.hpp) and prints the verdict.
//
// There are three verdicts. A property that holds has a proof, or every reachable state was visited; a counterexample
// has been replayed before it is printed; everything else is unknown, with the reason. Ctrl-C ends the command with the
// facts known so far.
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "compiler/base/content_cache.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/pipeline/cache_folder.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/pipeline/error_sources.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/driver/exit_codes.hpp"
#include "compiler/driver/first_runs.hpp"
#include "compiler/pipeline/initial_fault.hpp"
#include "compiler/driver/interrupt_cancellation.hpp"
#include "compiler/pipeline/machine.hpp"
#include "compiler/driver/read_question.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/timed_models.hpp"
#include "compiler/driver/verify_text.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/evidence/proof_cache.hpp"
#include "compiler/verify/net/unread_cpp.hpp"
#include "compiler/verify/portfolio/search_bad_state.hpp"
#include "runtime/explore/counterexample.hpp"

namespace bip::driver {

namespace {

// What C++ remembers is outside of a state: then states can't be visited and steps can't be replayed.
bool calls_cpp(const System& system) { return !system.code.functions.empty() || !system.code.ffi_types.empty(); }

// Of the time, for runs before the proof.
constexpr std::uint64_t kShareOfRuns = 8;

// Models with C++: what decides about no state is taken out, so that they can be searched. Returns a note, empty if
// the system is as before.
std::string remove_unread_cpp(Compilation& c, const verify::Question& question) {
  const bool asks_state = question.what == verify::QuestionKind::State;
  std::optional<System> simple =
      verify::without_unread_cpp(*c.system, asks_state ? verify::data_of(question.property) : std::vector<DataRef>());
  if (!simple) return {};
  c.lowered.reset();
  c.system = std::move(*simple);
  c.lowered = lower::lower(*c.system, c.root_name);
  return "note: the model's C++ is taken to return; nothing that it computes decides about a state\n";
}

// A deadlock or an error that a run meets, of a model whose C++ nothing else follows.
std::optional<VerdictText> first_runs(const VerifyArguments& arguments, Compilation& c,
                                      const verify::Question& question) {
  const bool asks_errors = question.what == verify::QuestionKind::NoErrors;
  if (!asks_errors && question.what != verify::QuestionKind::DeadlockFreedom) return std::nullopt;
  const auto seconds = static_cast<unsigned>(arguments.timeout / kShareOfRuns + 1);
  const std::optional<std::string> run =
      run_to_end(c, arguments.backend, asks_errors ? rt::End::Fault : rt::End::Deadlock, seconds);
  if (!run) return std::nullopt;
  return VerdictText{kViolated, asks_errors ? "error" : "deadlock", *run};
}

// A verdict that needed no proof.
int write(const VerifyArguments& arguments, const verify::Question& question, const VerdictText& verdict) {
  verify::Decision none;
  none.outcome = verify::Outcome::Violated;
  const std::string text = arguments.json ? verdict_json(verdict, question, none, nullptr) : verdict.text;
  std::fwrite(text.data(), 1, text.size(), stdout);
  return verdict.exit_code;
}

// One line on a terminal, rewritten at most ten times a second; nothing elsewhere.
class ProofProgressLine {
  using WallClock = std::chrono::steady_clock;

 public:
  void show(const char* phase, std::uint64_t count, const char* unit) {
    const WallClock::time_point now = WallClock::now();
    if (!is_terminal_ || now < next_) return;
    next_ = now + std::chrono::milliseconds(100);
    const double seconds = std::chrono::duration<double>(now - start_).count();
    if (phase != phase_) {
      phase_ = phase;
      phase_start_ = now;
    }
    const double in_phase = std::chrono::duration<double>(now - phase_start_).count();
    const std::string rate =
        in_phase > 0.5 ? fmt::format(", {:.0f} a second", static_cast<double>(count) / in_phase) : "";
    std::fputs(
        fmt::format("\r\x1b[K{}: {} {}{}   {:.1f} s (Ctrl-C ends it)", phase, count, unit, rate, seconds).c_str(),
        stderr);
    is_shown_ = true;
  }
  ~ProofProgressLine() {
    if (is_shown_) std::fputs("\r\x1b[K", stderr);
  }

 private:
  bool is_terminal_ = ::isatty(STDERR_FILENO) == 1;
  bool is_shown_ = false;
  const char* phase_ = nullptr;
  WallClock::time_point start_ = WallClock::now(), next_ = start_ + std::chrono::milliseconds(300),
                        phase_start_ = start_;
};

// Processor time for the question about errors, which the user did not ask, in seconds.
constexpr double kErrorSeconds = 0.5;

// The note of a verdict that holds: whether a run can end in an error. The same engines decide it, within
// kErrorSeconds.
std::string error_remark(const Compilation& c, const verify::Question& question, const verify::Decision& decision,
                         verify::Portfolio& portfolio, const verify::PortfolioLimits& limits) {
  const bool asked_else =
      question.what == verify::QuestionKind::DeadlockFreedom || question.what == verify::QuestionKind::State;
  // Who visited all states has met the errors.
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

// A certificate of an earlier run says what this one refutes.
void remove_certificate(Compilation& c, const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return;
  if (std::filesystem::remove(path, error)) {
    std::fprintf(stderr, "note: `%s` held an earlier certificate and was removed\n", path.c_str());
  } else {
    c.diags.report(Diag::kB5004, {}, path, error.message());
  }
}

// The run that violates the property, if one was found and a file was asked for.
void write_counterexample(const VerifyArguments& arguments, Compilation& c, const verify::Decision& decision) {
  const verify::Counterexample* const found = decision.counterexample();
  if (arguments.trace_path.empty() || decision.outcome != verify::Outcome::Violated || found == nullptr) return;
  const std::string trace =
      rt::trace_of_counterexample(c.lowered->image, rt::MaximalProgress::On, found->choices, rt::TraceFormat::Json);
  if (const Result<bool> written = write_file(arguments.trace_path, trace); !written)
    c.diags.report(Diag::kB5004, {}, arguments.trace_path, written.error());
}

}  // namespace

int command_verify(const VerifyArguments& arguments) {
  Compilation c(arguments.compile);
  if (arguments.compile.emit != EmitKind::None) {
    emit_stage(c, arguments.file, Optimisation::Auto);
    return report(c);
  }
  if (!compile(c, arguments.file, Stage::Image) || !check_outputs(c, {arguments.certificate, arguments.trace_path}))
    return report(c);
  const std::string property = arguments.partial ? std::string() : arguments.property;
  std::optional<verify::Question> asked = read_question("verify", property, *c.system);
  if (!asked) return kUsage;
  verify::Question question = std::move(*asked);
  if (arguments.partial) question.what = verify::QuestionKind::NoLocalDeadlock;
  const std::string note =
      calls_cpp(*c.system) && arguments.certificate.empty() ? remove_unread_cpp(c, question) : std::string();
  if (!calls_cpp(*c.system) && question.what != verify::QuestionKind::NoErrors) {
    if (const std::string fault = initial_fault(*c.system); !fault.empty())
      return write(arguments, question, {kModelErrors, "no-state", fmt::format("no run reaches a state: {}\n", fault)});
  }
  if (calls_cpp(*c.system) && !c.options.refuses_cpp) {
    if (const std::optional<VerdictText> met = first_runs(arguments, c, question))
      return write(arguments, question, *met);
  }
  if (system::is_timed(*c.system)) return verify_timed(arguments, c, question, note);

  verify::PortfolioLimits limits;
  const InterruptCancellation interrupt;
  limits.cancellation = interrupt.token().within(static_cast<double>(arguments.timeout));
  limits.threads = processors();
  limits.megabytes = static_cast<std::size_t>(arguments.megabytes);
  limits.wants_certificate = !arguments.certificate.empty();
  limits.wants_minimal_proof = limits.wants_certificate || arguments.why;
  Executor executor(MachineCode::Fresh);
  bool is_ready = true;
  const auto prepare = [&] {
    is_ready = executor.prepare(c, arguments.backend, Optimisation::Auto);
    return is_ready;
  };
  ContentCache cache(KeptKind::Proof, cache_folder(arguments.compile.cache).string(),
                     arguments.compile.cache.megabytes << 20);
  verify::ProofCache proofs(cache, cache_version());
  verify::Decision decision;
  VerdictText verdict;
  double seconds = 0;
  {
    ProofProgressLine progress;
    const auto show = [&](const char* phase, std::uint64_t count, const char* unit) {
      progress.show(phase, count, unit);
    };
    const verify::StateAccess access =
        calls_cpp(*c.system) ? verify::StateAccess::CallsCpp : verify::StateAccess::Searchable;
    verify::Portfolio portfolio(*c.system, c.lowered->image, access, prepare, show);
    if (arguments.reuses && cache.is_on()) portfolio.use_cache(&proofs);
    const verify::ProcessClock::time_point start = verify::ProcessClock::now();
    decision = portfolio.decide(question, limits);
    seconds = std::chrono::duration<double>(verify::ProcessClock::now() - start).count();
    if (is_ready)
      verdict =
          verdict_text(c, question, decision, portfolio, arguments.why ? Explanation::Evidence : Explanation::None);
    verdict.text += note;
    if (!arguments.certificate.empty() && decision.outcome == verify::Outcome::Holds) {
      const Result<bool> written =
          write_file(arguments.certificate, verify::certificate(portfolio, question, decision, *c.system, c.root_name));
      if (!written) c.diags.report(Diag::kB5004, {}, arguments.certificate, written.error());
    } else if (!arguments.certificate.empty() && decision.outcome == verify::Outcome::Violated) {
      remove_certificate(c, arguments.certificate);
    }
    if (is_ready) write_counterexample(arguments, c, decision);
    if (is_ready) verdict.text += error_remark(c, question, decision, portfolio, limits);
  }
  if (const int code = report(c); code != 0 || !is_ready) return code;
  const VerifyStats stats{seconds, decision.candidates(), arguments.reuses && cache.is_on() ? &proofs : nullptr};
  const VerifyStats* shown = arguments.stats ? &stats : nullptr;
  const std::string text = arguments.json ? verdict_json(verdict, question, decision, shown)
                                          : verdict.text + (shown != nullptr ? stats_text(stats) : "");
  std::fwrite(text.data(), 1, text.size(), stdout);
  return verdict.exit_code;
}

}  // namespace bip::driver
