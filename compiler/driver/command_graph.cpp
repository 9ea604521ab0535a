// `bipc graph`: prints the System as a picture or as JSON.
#include <cstdio>

#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/driver/report.hpp"

namespace bip::driver {

int command_graph(const GraphArguments& arguments) {
  Compilation c(arguments.compile);
  if (c.options.emit != EmitKind::None) {
    emit_stage(c, arguments.file, Optimisation::Auto);
  } else if (compile(c, arguments.file, Stage::System)) {
    const std::string text = arguments.format == EmitKind::Json ? graph::json(*c.system, arguments.show)
                                                                : graph::dot(*c.system, arguments.show);
    std::fwrite(text.data(), 1, text.size(), stdout);
  }
  return report(c);
}

}  // namespace bip::driver
