// Options for machine code (optimisation, cache, debugging, profile) and for thread priority. See cli_options.hpp.
#include "compiler/driver/cli_options.hpp"

#include <fmt/format.h>

namespace bip::driver {

void add_cache_options(CLI::App& command, CacheOptions& cache) {
  CLI::Option* off = command.add_flag("--no-cache", cache.is_off, "neither read nor write the cache");
  command
      .add_option("--cache", cache.folder, "folder of the cache (default: $XDG_CACHE_HOME/bipc, else ~/.cache/bipc)")
      ->type_name("DIR")
      ->excludes(off);
  command
      .add_option("--cache-size", cache.megabytes,
                  "size limit of the cache; the least recently used entries are removed (default: 256)")
      ->check(CLI::Range(1, 1 << 20))
      ->type_name("MB");
}

void add_optimisation(CLI::App& app, Optimisation& level, bool with_o1, const std::string& help) {
  const std::string shown = with_o1 ? "0|1|2" : "0|2";
  app.add_option_function<std::string>(
         "-O",
         [&level](const std::string& text) {
           level = text == "0" ? Optimisation::O0 : text == "1" ? Optimisation::O1 : Optimisation::O2;
         },
         help)
      ->check(CLI::Validator(
          [shown, with_o1](std::string& text) {
            return text == "0" || text == "2" || (with_o1 && text == "1")
                       ? ""
                       : fmt::format("`{}` is not one of {}", text, shown);
          },
          ""))
      ->type_name(shown);
}

void add_code_options(CLI::App& command, RunArguments& a) {
  command
      .add_flag(
          "-g", a.for_debuggers,
          "generate debug information that maps machine code to lines of the model, for gdb and perf (--backend=jit)")
      ->excludes("--explore");
  CLI::Option* explores = command.get_option("--explore");
  command.add_flag("--profile", a.profile, "print a profile at the end: time per interaction, type, guard and action")
      ->excludes(explores);
  command.add_option("--profile-json", a.profile_path, "write the profile as JSON to PATH")
      ->type_name("PATH")
      ->excludes(explores);
}

void add_real_time_priority(CLI::App& command, int& priority) {
  command
      .add_option("--real-time-priority", priority,
                  "in real time, run with scheduling priority N (SCHED_FIFO, 1 to 99) and locked memory; a refusal is "
                  "a warning")
      ->check(CLI::Range(1, 99))
      ->type_name("N");
}

}  // namespace bip::driver
