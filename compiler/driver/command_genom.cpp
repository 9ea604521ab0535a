// `bipc genom`: translates descriptions of robot modules to one BIP package (compiler/genom).
#include <cstdio>

#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/genom_files.hpp"
#include "compiler/driver/report.hpp"

namespace bip::driver {

int command_genom(const GenomArguments& arguments) {
  Compilation c(arguments.compile);
  if ((arguments.skeleton || !arguments.codels.empty()) && arguments.output.empty()) {
    return usage_error(fmt::format("`--{}` writes files beside the output", arguments.skeleton ? "skeleton" : "codels"),
                       "add `-o FILE`");
  }
  const genom::TranslateOptions options = translate_options(arguments, arguments.files, "");
  if (const auto modules = load_modules(c, arguments.files, arguments.side_file, options)) {
    genom::GenerateOptions generate = options.generate;
    if (generate.package.empty()) generate.package = genom::package_of(*modules);
    write_translation(c, arguments, genom::write_package(*modules, generate), generate.package);
  }
  return report(c);
}

}  // namespace bip::driver
