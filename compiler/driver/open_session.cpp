// See open_session.hpp.
#include "compiler/driver/open_session.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <optional>
#include <utility>

#include "compiler/driver/load_moves.hpp"
#include "compiler/driver/report.hpp"

namespace bip::driver {

OpenSession open_session(Compilation& c, Executor& executor, const SessionArguments& arguments,
                         rt::SessionOptions& options) {
  std::optional<RunFileText> run;
  if (!arguments.trace_path.empty()) {
    run = read_run(c, arguments.trace_path, options);
    if (!run) return {nullptr, report(c)};
  }
  const bool is_ready = executor.prepare(c, arguments.backend, Optimisation::Auto);
  if (const int code = report(c); code != 0 || !is_ready) return {nullptr, code};
  auto session = std::make_unique<rt::DebugSession>(c.lowered->image, options);
  if (!arguments.events_path.empty()) {
    if (const Result<bool> are_read = session->read_events(arguments.events_path); !are_read) {
      print_error_words(fmt::format("error: {}", are_read.error()));
      return {nullptr, kUsage};
    }
  }
  (void)session->start();
  if (run && !load_moves(c, *run, *session)) return {nullptr, report(c)};
  return {std::move(session)};
}

}  // namespace bip::driver
