// `bipc run`: compile, choose an executor, run to the end that comes first. A folder is run by its own program `run`, which finds us as $BIPC.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/driver/executor.hpp"
#include "compiler/driver/exit_codes.hpp"
#include "compiler/driver/report.hpp"

namespace bip::driver {
namespace {

namespace fs = std::filesystem;

bool has_own_program(const std::string& folder) {
  std::error_code error;
  return fs::is_directory(folder, error) && ::access((fs::path(folder) / "run").c_str(), X_OK) == 0;
}

// Comes back only if the program cannot be started.
int run_folder(const RunArguments& arguments) {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (!error) ::setenv("BIPC", self.c_str(), 0);
  const std::string program = fs::absolute(fs::path(arguments.file) / "run", error).string();
  std::vector<std::string> words{program};
  if (arguments.run.has_seed) words.insert(words.end(), {"--seed", std::to_string(arguments.run.seed)});
  if (arguments.run.speed > 0) words.insert(words.end(), {"--speed", std::to_string(arguments.run.speed)});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::execv(program.c_str(), argv.data());
  std::fprintf(stderr, "error: `%s` cannot be started\n", program.c_str());
  return kUsage;
}

}  // namespace

int command_run(const RunArguments& arguments) {
  if (has_own_program(arguments.file)) return run_folder(arguments);
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
