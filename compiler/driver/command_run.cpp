// `bipc run`: compiles, selects an executor, and runs to the limit, a deadlock, an error or Ctrl-C. A folder is run by
// its own program `run`, which receives the path of bipc in $BIPC.
#include <unistd.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

#include "compiler/base/write_file.hpp"
#include "compiler/diag/render.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/ffi_build.hpp"
#include "compiler/driver/distributed_runs.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/fabric_loader.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/profile_text.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/terminal.hpp"
#include "compiler/driver/usage_error.hpp"
#include "compiler/system/system_parts.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::driver {
namespace {

// Of --checkpoint without --checkpoint-file.
constexpr const char* kCheckpointFile = "run.checkpoint";

namespace fs = std::filesystem;

bool has_own_program(const std::string& folder) {
  std::error_code error;
  return fs::is_directory(folder, error) && ::access((fs::path(folder) / "run").c_str(), X_OK) == 0;
}

// The format of a trace file, for a folder's program; it refuses formats that it does not write.
const char* format_name(rt::TraceFormat format) {
  return format == rt::TraceFormat::Steps ? "json" : rt::row_of(format).name;
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
  if (!arguments.run.trace_path.empty())
    words.insert(words.end(),
                 {"--trace", arguments.run.trace_path, "--trace-format", format_name(arguments.run.format)});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::execv(program.c_str(), argv.data());
  print_error_words(fmt::format("error: `{}` cannot be started", program));
  return kUsage;
}

int run_profiled(Compilation& c, const RunArguments& arguments, rt::RunOptions options) {
  rt::Profile profile(c.lowered->codes);
  options.profile = &profile;
  const rt::RunResult result = rt::run(c.lowered->image, options, stdout, stderr);
  if (result.exit_code == 2) return result.exit_code;
  if (arguments.profile) {
    const std::string text = profile_text(*c.lowered, profile, result.steps);
    std::fwrite(text.data(), 1, text.size(), stderr);
  }
  if (arguments.profile_path.empty()) return result.exit_code;
  if (const Result<bool> written = write_file(arguments.profile_path, profile_json(*c.lowered, profile, result.steps));
      !written) {
    print_error_words(fmt::format("error[B5004]: cannot write `{}`: {}", arguments.profile_path, written.error()));
    return kModelErrors;
  }
  return result.exit_code;
}

// Returns whether the run may start interpreted while another thread compiles. It may not if the user chose the code,
// or if a second thread interferes: an engine with several threads, real time, the model's C++ (which may call rand()
// or end the process).
bool begins_interpreted(const Compilation& c, const RunArguments& a) {
  return a.backend == Backend::Auto && a.optimisation == Optimisation::Auto && !a.for_debuggers &&
         a.run.engine == rt::Engine::Sequential && !(a.run.speed > 0) && !a.run.explore && !a.run.interactive &&
         !uses_ffi(c);
}

// A node takes steps many at once by their machine code, if it writes nothing of them but their interactions; that pays
// for what it costs to compile.
Optimisation optimisation_of(const RunArguments& a) {
  constexpr std::uint64_t kWorthwhile = std::uint64_t{1} << 20;
  const bool writes_little = a.run.trace_path.empty() || rt::row_of(a.run.format).needs_only_interactions;
  const bool takes_many = a.run.engine == rt::Engine::Distributed && a.run.silent && !a.run.debug && writes_little &&
                          a.run.limit >= kWorthwhile;
  return a.optimisation == Optimisation::Auto && takes_many ? Optimisation::O2 : a.optimisation;
}

// How a place of the model is shown below a run-time error: with its line, if the text was read.
std::string show_place(const Compilation& c, rt::SourceLine at, const diag::Palette& colors) {
  const FileId file(at.file);
  if (at.file >= c.sources.size() || c.sources.name(file) != c.lowered->image.files[at.file]) return {};
  return diag::excerpt(c.sources, {at.file, at.line, at.column}, colors);
}

// Steps so far and their rate: on a terminal, of a run that says nothing else.
class StepsProgressLine {
  using WallClock = std::chrono::steady_clock;

 public:
  void show(std::uint64_t steps) {
    const WallClock::time_point now = WallClock::now();
    if (now < next_) return;
    const double seconds = std::chrono::duration<double>(now - start_).count();
    write_now(stderr, fmt::format("\r\x1b[K{} steps, {:.1f} million a second   {:.0f} s (Ctrl-C ends it)", steps,
                                  static_cast<double>(steps) / seconds / 1e6, seconds));
    next_ = now + std::chrono::milliseconds(200);
    is_shown_ = true;
  }
  void clear() {
    if (std::exchange(is_shown_, false)) write_now(stderr, "\r\x1b[K");
  }

 private:
  WallClock::time_point start_ = WallClock::now(), next_ = start_ + std::chrono::seconds(1);
  bool is_shown_ = false;
};

// The image has all of the instances; what is compiled or reported from now on needs types and code only.
void release_instances(Compilation& c) {
  system::release_instances(*c.system);
#if defined(__GLIBC__)
  ::malloc_trim(0);
#endif
}

}  // namespace

int command_run(const RunArguments& arguments) {
  if (!arguments.misplaced.empty()) return usage_error(arguments.misplaced, "`bipc run --help`");
  if (has_own_program(arguments.file)) {
    if (!arguments.compile.refuses_cpp) return run_folder(arguments);
    print_error_words(fmt::format("error: `{}` has its own program, and `--no-cpp` refuses it", arguments.file));
    return kUsage;
  }
  Compilation c(arguments.compile);
  if (arguments.compile.emit != EmitKind::None) {
    emit_stage(c, arguments.file, arguments.optimisation);
    return report(c);
  }
  Executor executor;
  const bool profiles = arguments.profile || !arguments.profile_path.empty();
  bool ready = compile(c, arguments.file, Stage::Image) &&
               check_outputs(c, {arguments.run.trace_path, arguments.run.record_path, arguments.run.checkpoint_path,
                                 arguments.profile_path});
  rt::Placement placement;
  ready = ready && prepare_distributed(c, arguments, placement);
  if (ready) c.lowered->calls_rows = profiles;
  const bool tiered = ready && !profiles && begins_interpreted(c, arguments);
  ready = ready && (tiered ? executor.prepare_tiered(c)
                           : executor.prepare(c, arguments.backend, optimisation_of(arguments),
                                              arguments.for_debuggers ? ForDebuggers::Yes : ForDebuggers::No));
  if (const int code = report(c); code != 0 || !ready) return code;
  release_instances(c);
  rt::RunOptions options = arguments.run;
  if (options.checkpoint_every > 0 && options.checkpoint_path.empty()) options.checkpoint_path = kCheckpointFile;
  options.new_code = executor.new_code();
  if (!placement.nodes.empty()) options.placement = &placement;
  if (options.engine == rt::Engine::Distributed) {
    const Result<const rt::FabricFactory*> fabrics = load_fabric();
    if (!fabrics) {
      print_error_words(fmt::format("error: {}", fabrics.error()));
      return kUsage;
    }
    options.fabrics = *fabrics;
  }
  const diag::Palette colors = diag::palette(wants_color(c.options.color, STDERR_FILENO) ? Color::On : Color::Off);
  options.show_source = [&](rt::SourceLine at) { return show_place(c, at, colors); };
  StepsProgressLine progress;
  if (options.silent && ::isatty(STDERR_FILENO) == 1) {
    options.on_progress = [&](std::uint64_t steps) { progress.show(steps); };
    options.before_end = [&] { progress.clear(); };
  }
  const int code =
      profiles ? run_profiled(c, arguments, options) : rt::run(c.lowered->image, options, stdout, stderr).exit_code;
  if (options.stats) std::fputs(executor.summary().c_str(), stderr);
  return code;
}

}  // namespace bip::driver
