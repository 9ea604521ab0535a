// `bipc step`: a debugging session on the console (compiler/docs/step.md). Without a terminal it reads commands from
// standard input and repeats each before its answer, so that a session is a file.
#include <cstdio>

#include "compiler/base/write_file.hpp"
#include "compiler/debug/console.hpp"
#include "compiler/debug/line_reader.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/open_session.hpp"
#include "compiler/driver/report.hpp"
#include "runtime/engine/interrupt.hpp"

namespace bip::driver {

namespace {

void print_text(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stdout); }

// The exit code: 2 if input that is no terminal had a command that was refused.
int read_commands(rt::DebugSession& session, const debug::DebugModel& model, std::uint64_t seed) {
  bool was_refused = false;
  debug::ConsoleOutput output;
  output.print = print_text;
  output.refuse = [&](const std::string& problem, const std::string& help) {
    was_refused = true;
    std::fflush(stdout);
    const std::string text = (problem.starts_with("error[") ? "" : "bipc: ") + problem + "\n" +
                             (help.empty() ? "" : "  = help: " + help + "\n");
    std::fputs(text.c_str(), stderr);
  };
  output.write = [](const std::string& path, const std::string& text) {
    const Result<bool> written = write_file(path, text);
    return written ? std::string() : written.error();
  };
  debug::Console console(session, model, seed, output);
  debug::LineReader reader([&console](const std::string& word) { return console.complete(word); });
  if (reader.is_terminal()) print_text("`h` lists the commands.\n");
  console.print_state();
  while (const std::optional<std::string> line = reader.read(console.prompt())) {
    if (!reader.is_terminal()) print_text("> " + *line + "\n");
    if (console.execute(*line) == debug::Console::Next::Quit) break;
  }
  std::fflush(stdout);
  return was_refused && !reader.is_terminal() ? kUsage : kOk;
}

}  // namespace

int command_step(const StepArguments& arguments) {
  Compilation c(arguments.compile);
  Executor executor;
  rt::SessionOptions options = arguments.session;
  if (!compile(c, arguments.file, Stage::Image)) return report(c);
  const OpenSession opened = open_session(c, executor, arguments, options);
  if (opened.session == nullptr) return opened.exit_code;
  rt::DebugSession& session = *opened.session;
  if (arguments.has_at && arguments.at != session.position() && session.go_to(arguments.at) == rt::Halt::Refused)
    return usage_error(fmt::format("--at {}: {}", arguments.at, session.problem()));
  return read_commands(session, debug::DebugModel(*c.system, c.lowered->image), options.seed);
}

}  // namespace bip::driver
