// `bipc run`: compile, choose an executor, run to the end that comes first.
#include <cstdio>

#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/driver/executor.hpp"
#include "compiler/driver/report.hpp"

namespace bip::driver {

int command_run(const RunArguments& arguments) {
  Compilation c(arguments.compile);
  if (arguments.compile.emit != EmitKind::None) {
    emit_stage(c, arguments.file, arguments.optimisation);
    return report(c);
  }
  Executor executor;
  const bool ready = compile(c, arguments.file, Stage::Image) && executor.prepare(c, arguments.backend, arguments.optimisation);
  if (const int code = report(c); code != 0 || !ready) return code;
  return rt::run(c.lowered->image, arguments.run, stdout, stderr).exit_code;
}

}  // namespace bip::driver
