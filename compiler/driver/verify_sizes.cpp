// See verify_sizes.hpp.
#include "compiler/driver/verify_sizes.hpp"

#include <cstdio>
#include <string>

#include "compiler/base/json_text.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/interrupt_cancellation.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/write_certificate.hpp"
#include "compiler/library/decide_sizes.hpp"
#include "compiler/pipeline/exit_codes.hpp"

namespace bip::driver {

int verify_for_all_sizes(const VerifyArguments& arguments) {
  const Result<library::SizeQuestion> asked = library::read_size_question(arguments.for_all);
  if (!asked) return usage_error("--for-all: " + asked.error());
  if (arguments.file.ends_with(".bsys"))
    return usage_error("--for-all needs a model with sizes, and a .bsys file is a system of one size");
  CompileOptions options = arguments.compile;
  const std::string root = options.root;
  options.root.clear();
  options.emit = EmitKind::None;
  const EmitKind emit = arguments.compile.emit;
  if (emit != EmitKind::None && emit != EmitKind::System)
    return usage_error("--for-all prints no other stage than --emit=system");
  pipeline::Compilation c(options);
  if (!compile(c, arguments.file, pipeline::Stage::Model) ||
      !check_outputs(c, {arguments.certificate, arguments.trace_path}) ||
      !check_writable(c, {arguments.certificate, arguments.trace_path}))
    return report(c);
  library::VerifyRequest request = arguments;
  request.wants_certificate = !arguments.certificate.empty();
  request.wants_trace = !arguments.trace_path.empty();
  const InterruptCancellation interrupt;
  const verify::CancellationToken token =
      arguments.wall_timeout > 0 ? interrupt.token().within_wall_clock(arguments.wall_timeout) : interrupt.token();
  const library::SizeVerdict found = emit == EmitKind::System
                                         ? library::print_all_sizes(c, root, *asked)
                                         : library::decide_for_all_sizes(request, c, root, *asked, token);
  if (!found.usage_error.empty()) return usage_error(found.usage_error);
  if (found.refused) return report(*found.refused);
  if (emit == EmitKind::None) write_certificate(c, arguments.certificate, found.verdict);
  if (!arguments.trace_path.empty() && found.verdict.counterexample) {
    if (const Result<bool> written = write_file(arguments.trace_path, found.verdict.counterexample->trace); !written)
      c.diags.report(Diag::kB5004, {}, arguments.trace_path, written.error());
  }
  if (const int code = report(c); code != 0) return code;
  if (emit != EmitKind::None && found.verdict.exit_code != pipeline::kOk) {
    print_error_words(found.verdict.text.substr(0, found.verdict.text.find('\n')));
    return found.verdict.exit_code;
  }
  const std::string text =
      arguments.json && emit == EmitKind::None ? json_line(found.verdict.json) + '\n' : found.verdict.text;
  std::fwrite(text.data(), 1, text.size(), stdout);
  return found.verdict.exit_code;
}

}  // namespace bip::driver
