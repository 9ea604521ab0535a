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

#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/first_runs.hpp"
#include "compiler/driver/interrupt_cancellation.hpp"
#include "compiler/driver/read_question.hpp"
#include "compiler/library/decide.hpp"
#include "compiler/driver/report.hpp"
#include "runtime/explore/counterexample.hpp"

namespace bip::driver {

namespace {

// Of the time, for runs before the proof.
constexpr double kShareOfRuns = 8;

// A deadlock or an error that a run meets, of a model whose C++ nothing else follows.
std::optional<library::Verdict> first_runs(const VerifyArguments& arguments, Compilation& c,
                                           const verify::Question& question) {
  const bool asks_errors = question.what == verify::QuestionKind::NoErrors;
  if (!asks_errors && question.what != verify::QuestionKind::DeadlockFreedom) return std::nullopt;
  const auto seconds = static_cast<unsigned>(arguments.timeout / kShareOfRuns + 1);
  const std::optional<std::string> run =
      run_to_end(c, arguments.backend, asks_errors ? rt::End::Fault : rt::End::Deadlock, seconds);
  if (!run) return std::nullopt;
  return library::plain_verdict(question, kViolated, asks_errors ? "error" : "deadlock", *run);
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
void write_counterexample(const VerifyArguments& arguments, Compilation& c, const library::Verdict& verdict) {
  if (arguments.trace_path.empty() || !verdict.counterexample) return;
  if (const Result<bool> written = write_file(arguments.trace_path, verdict.counterexample->trace); !written)
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
  library::VerifyRequest request = arguments;
  request.wants_certificate = !arguments.certificate.empty();
  request.wants_trace = !arguments.trace_path.empty();
  const std::optional<verify::Question> asked =
      read_question("verify", arguments.property, library::read_question(request, *c.system), *c.system);
  if (!asked) return kUsage;
  const verify::Question& question = *asked;
  const bool may_simplify = library::calls_cpp(*c.system) && !request.wants_certificate;
  const std::string note = may_simplify ? library::remove_unread_cpp(c, question) : std::string();
  std::optional<library::Verdict> verdict = library::decide_initial_fault(c, question);
  if (!verdict && library::calls_cpp(*c.system) && !c.options.refuses_cpp) verdict = first_runs(arguments, c, question);
  if (!verdict) {
    const InterruptCancellation interrupt;
    ProofProgressLine progress;
    verdict = library::decide(
        request, c, question, note, interrupt.token(),
        [&](const char* phase, std::uint64_t count, const char* unit) { progress.show(phase, count, unit); });
    if (!verdict->certificate.empty()) {
      const Result<bool> written = write_file(arguments.certificate, verdict->certificate);
      if (!written) c.diags.report(Diag::kB5004, {}, arguments.certificate, written.error());
    } else if (request.wants_certificate && verdict->exit_code == kViolated) {
      remove_certificate(c, arguments.certificate);
    }
    write_counterexample(arguments, c, *verdict);
  }
  if (const int code = report(c); code != 0 || !verdict->is_answered) return code;
  const std::string& text = arguments.json ? verdict->json : verdict->text;
  std::fwrite(text.data(), 1, text.size(), stdout);
  return verdict->exit_code;
}

}  // namespace bip::driver
