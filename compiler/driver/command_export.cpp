// `bipc export`: writes the System in the language of another tool (compiler/exchange).
#include <cstdio>

#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/driver/host_compiler.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/exchange/exchange.hpp"

namespace bip::driver {

int command_export(const ExportArguments& arguments) {
  Compilation c(arguments.compile);
  if (arguments.compile.emit != EmitKind::None) {
    emit_stage(c, arguments.file, Optimisation::Auto);
    return report(c);
  }
  std::string text;
  if (compile(c, arguments.file, Stage::Image)) {
    const bool is_promela = arguments.format == ExportFormat::Promela;
    const exchange::Options options{.maximal_progress = arguments.maximal_progress, .root_name = c.root_name};
    Result<std::string> made = is_promela ? exchange::promela(*c.system, options) : exchange::pnml(*c.system, options);
    if (!made) {
      c.diags.report(Diag::kB5060, {}, is_promela ? "Promela" : "PNML", made.error());
    } else if (arguments.output.empty()) {
      text = std::move(*made);
    } else if (const auto written = write_file(arguments.output, *made); !written) {
      c.diags.report(Diag::kB5004, {}, arguments.output, written.error());
    }
  }
  const int code = report(c);
  if (code == 0) std::fwrite(text.data(), 1, text.size(), stdout);
  return code;
}

}  // namespace bip::driver
