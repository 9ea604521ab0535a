// See first_runs.hpp. The child writes what it found, and what its handler of signals says, to files without names that
// both processes have open.
#include "compiler/driver/first_runs.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <iterator>
#include <memory>
#include <string_view>

#include <fmt/format.h>

#include "compiler/pipeline/executor.hpp"

namespace bip::driver {

namespace {

constexpr std::uint64_t kRuns = 16, kStepsOfRun = 10'000;
// The text of a longer run is cut.
constexpr std::size_t kMostText = 1 << 20;
// A file of a run, of which the end may be lost.
constexpr rlim_t kMostSaid = 64 << 20;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

// From a position on: the first of the file, or the last that may be read.
enum class Part : std::uint8_t { First, Last };
std::string text_of(std::FILE* file, Part part = Part::First) {
  std::string text;
  const bool is_at_end = part == Part::Last && std::fseek(file, -static_cast<long>(kMostText), SEEK_END) == 0;
  if (!is_at_end) std::rewind(file);
  char block[4096];
  while (const std::size_t got = std::fread(block, 1, sizeof block, file)) {
    text.append(block, got);
    if (text.size() > kMostText) break;
  }
  return text;
}

// Of the child: the standard error goes to the file.
void detach_standard_streams(std::FILE* said) {
  const int null = ::open("/dev/null", O_RDWR);
  if (null < 0) return;
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO}) (void)::dup2(null, stream);
  (void)::dup2(::fileno(said), STDERR_FILENO);
}

constexpr std::string_view kCrashLine = "error: signal ";

// What stands behind the last `head` in the text, to the end of its line.
std::string last_line(const std::string& text, std::string_view head) {
  const std::size_t at = text.rfind(head);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + head.size();
  return text.substr(begin, text.find('\n', begin) - begin);
}

// A signal of its own that ended the child; others come from outside, or say that it was out of time.
std::string crash_text(int status, std::FILE* said, std::FILE* seed_of_run) {
  constexpr int kCrashes[] = {SIGSEGV, SIGFPE, SIGBUS, SIGABRT, SIGILL};
  if (!WIFSIGNALED(status) ||
      std::find(std::begin(kCrashes), std::end(kCrashes), WTERMSIG(status)) == std::end(kCrashes))
    return {};
  // None before the first run, while the model's C++ is loaded: `bipc run` shows that.
  const std::string seed = text_of(seed_of_run);
  if (seed.empty()) return {};
  const std::string told = last_line(text_of(said, Part::Last), kCrashLine);
  return fmt::format("signal {}   (seed {})", told.empty() ? std::to_string(WTERMSIG(status)) : told, seed);
}

// In the child. A time lock is wanted as a deadlock is.
void run_all(Compilation& c, Backend backend, rt::End end, unsigned seconds, std::FILE* found, std::FILE* seed_of_run) {
  Executor executor(MachineCode::Fresh);
  if (!executor.prepare(c, backend, Optimisation::O0)) return;
  // What the model's C++ writes is not kept for ever.
  const rlimit limit{kMostSaid, kMostSaid};
  (void)::setrlimit(RLIMIT_FSIZE, &limit);
  (void)std::signal(SIGXFSZ, SIG_IGN);
  ::alarm(seconds);
  std::uint64_t fewest = kStepsOfRun + 1;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const File steps(std::tmpfile());
    if (steps == nullptr) return;
    // Seeds never have fewer digits than the one before.
    std::rewind(seed_of_run);
    std::fprintf(seed_of_run, "%llu", static_cast<unsigned long long>(seed));
    std::fflush(seed_of_run);
    rt::RunOptions options;
    options.seed = seed;
    options.has_seed = true;
    options.limit = fewest - 1;
    const rt::RunResult result = rt::run(c.lowered->image, options, steps.get(), steps.get());
    if (result.end != end && (result.end != rt::End::Fault || end != rt::End::Deadlock)) continue;
    const std::string best = text_of(steps.get());
    if (result.steps >= fewest || (result.end != end && !is_time_lock(best))) continue;
    fewest = result.steps;
    // The child may be ended at any time: what is there is one run, or the beginning of one.
    std::rewind(found);
    if (::ftruncate(::fileno(found), 0) != 0) return;
    std::fwrite(best.data(), 1, best.size(), found);
    std::fflush(found);
    if (fewest == 0) break;
  }
}

}  // namespace

bool is_time_lock(const std::string& run) { return run.find("error[R0020]") != std::string::npos; }

FirstRuns make_first_runs(Compilation& c, Backend backend, rt::End wanted, unsigned seconds) {
  const File found(std::tmpfile()), said(std::tmpfile()), seed(std::tmpfile());
  if (found == nullptr || said == nullptr || seed == nullptr) return {};
  std::fflush(stdout);
  std::fflush(stderr);
  const pid_t child = ::fork();
  if (child < 0) return {};
  if (child == 0) {
    detach_standard_streams(said.get());
    run_all(c, backend, wanted, seconds, found.get(), seed.get());
    // No destructor of the parent's objects runs twice.
    ::_exit(0);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  FirstRuns runs;
  runs.crash = crash_text(status, said.get(), seed.get());
  if (std::string text = text_of(found.get()); text.ends_with('\n')) runs.found = std::move(text);
  return runs;
}

}  // namespace bip::driver
