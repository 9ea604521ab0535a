// `bipc verify`: decides deadlock-freedom, run-time errors or a property of states
// (compiler/verify/portfolio/portfolio.hpp) and prints the verdict.
//
// There are three verdicts. A property that holds has a proof, or every reachable state was visited; a counterexample
// has been replayed before it is printed; everything else is unknown, with the reason. Ctrl-C ends the command with the
// facts known so far.
#include <cstdio>
#include <filesystem>
#include <optional>

#include "compiler/base/write_file.hpp"
#include "compiler/driver/answer_question.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/read_question.hpp"
#include "compiler/library/decide.hpp"
#include "compiler/driver/report.hpp"

namespace bip::driver {

namespace {

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
  const library::Verdict verdict = answer_question(request, c, question);
  if (!verdict.certificate.empty()) {
    const Result<bool> written = write_file(arguments.certificate, verdict.certificate);
    if (!written) c.diags.report(Diag::kB5004, {}, arguments.certificate, written.error());
  } else if (request.wants_certificate && verdict.exit_code == kViolated) {
    remove_certificate(c, arguments.certificate);
  }
  write_counterexample(arguments, c, verdict);
  if (const int code = report(c); code != 0 || !verdict.is_answered) return code;
  const std::string& text = arguments.json ? verdict.json : verdict.text;
  std::fwrite(text.data(), 1, text.size(), stdout);
  return verdict.exit_code;
}

}  // namespace bip::driver
