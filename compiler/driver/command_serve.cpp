// `bipc serve`: runs a model in real time while clients communicate with it (compiler/docs/serve.md).
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/serve/serve_image.hpp"

namespace bip::driver {

int command_serve(const ServeArguments& arguments) {
  Compilation c(arguments.compile);
  Executor executor;
  const bool ready = compile(c, arguments.file, Stage::Image) && check_outputs(c, {arguments.trace_path}) &&
                     executor.prepare(c, arguments.backend, Optimisation::Auto);
  if (const int code = report(c); code != 0 || !ready) return code;
  return serve::serve_image(c.lowered->image, c.lowered->library, arguments);
}

}  // namespace bip::driver
