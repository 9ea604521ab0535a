// See answer_question.hpp.
#include "compiler/driver/answer_question.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>

#include <fmt/format.h>

#include "compiler/driver/first_runs.hpp"
#include "compiler/driver/interrupt_cancellation.hpp"
#include "compiler/pipeline/exit_codes.hpp"

namespace bip::driver {

namespace {

// Of the time, for runs before the proof.
constexpr double kShareOfRuns = 8;

// What random runs say, of a model whose C++ nothing else follows.
struct RunsVerdict {
  std::optional<library::Verdict> verdict;  // a deadlock or an error that a run meets
  std::string note;
};

RunsVerdict first_runs(const library::VerifyRequest& request, Compilation& c, const verify::Question& question) {
  const bool asks_errors = question.what == verify::QuestionKind::NoErrors;
  if (!asks_errors && question.what != verify::QuestionKind::DeadlockFreedom) return {};
  const double limit = request.wall_timeout > 0 ? std::min(request.timeout, request.wall_timeout) : request.timeout;
  const auto seconds = static_cast<unsigned>(limit / kShareOfRuns + 1);
  const FirstRuns runs = make_first_runs(c, request.backend, asks_errors ? rt::End::Fault : rt::End::Deadlock, seconds);
  RunsVerdict said;
  if (asks_errors && !runs.found && !runs.crash.empty())
    said.verdict = library::plain_verdict(question, kViolated, "error", "error: a run crashes: " + runs.crash + '\n');
  else if (runs.found)
    said.verdict = library::plain_verdict(question, kViolated,
                                          asks_errors                 ? "error"
                                          : is_time_lock(*runs.found) ? "time lock"
                                                                      : "deadlock",
                                          *runs.found);
  if (!runs.crash.empty()) said.note = "note: a run crashes: " + runs.crash + '\n';
  return said;
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

}  // namespace

library::Verdict answer_question(const library::VerifyRequest& request, Compilation& c,
                                 const verify::Question& question, const std::string& note) {
  if (std::optional<library::Verdict> fault = library::decide_initial_fault(c, question)) return *fault;
  std::string notes = note;
  if (library::has_undetermined_values(*c.system) && !c.options.refuses_cpp) {
    RunsVerdict runs = first_runs(request, c, question);
    if (runs.verdict) return *std::move(runs.verdict);
    notes += runs.note;
  }
  const InterruptCancellation interrupt;
  ProofProgressLine progress;
  return library::decide(
      request, c, question, notes, interrupt.token(),
      [&](const char* phase, std::uint64_t count, const char* unit) { progress.show(phase, count, unit); });
}

}  // namespace bip::driver
