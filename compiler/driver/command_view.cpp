// `bipc view`: a page with the pictures of a model and a run of it (compiler/docs/view.md).
#include <cstdio>
#include <filesystem>

#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/load_moves.hpp"
#include "compiler/driver/page_title.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/view/page.hpp"
#include "compiler/view/run_record.hpp"
#include "runtime/explore/counterexample.hpp"

namespace bip::driver {

int command_view(const ViewArguments& arguments) {
  Compilation c(arguments.compile);
  Executor executor;
  rt::SessionOptions options = arguments.session;
  const std::string output =
      arguments.output.empty() ? std::filesystem::path(arguments.file).stem().string() + ".html" : arguments.output;
  if (!compile(c, arguments.file, Stage::Image) || !check_outputs(c, {output})) return report(c);
  std::optional<RunFileText> run;
  if (!arguments.trace_path.empty()) {
    run = read_run(c, arguments.trace_path, options);
    if (!run) return report(c);
  }
  const bool is_ready = executor.prepare(c, arguments.backend, Optimisation::Auto);
  if (const int code = report(c); code != 0 || !is_ready) return code;
  rt::DebugSession session(c.lowered->image, options);
  std::string error;
  if (!arguments.events_path.empty() && !session.read_events(arguments.events_path, error)) {
    std::fprintf(stderr, "error: %s\n", error.c_str());
    return kUsage;
  }
  (void)session.start();
  std::uint64_t steps = arguments.steps;
  if (run) {
    if (!load_moves(c, *run, session)) return report(c);
    steps = session.position();
    // The page shows the run from its beginning.
    if (steps != 0 && session.go_to(0) == rt::Halt::Refused) {
      std::fprintf(stderr,
                   "error[B5041]: the session cannot go back: %s\n  = help: `--trust-cpp` goes back all the same: C++ "
                   "functions are then taken to depend on nothing but their arguments\n",
                   session.problem().c_str());
      return kUsage;
    }
  }
  const std::string page = view::page(*c.system, page_title(*c.system, arguments.file), arguments.picture,
                                      view::record_run(*c.system, session, steps, options.seed));
  if (const auto written = write_file(output, page); !written) {
    c.diags.report(Diag::kB5004, {}, output, written.error());
    return report(c);
  }
  std::printf("%s: %s; a browser opens it\n", output.c_str(), rt::counted(session.position(), "step").c_str());
  return kOk;
}

}  // namespace bip::driver
