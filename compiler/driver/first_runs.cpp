// See first_runs.hpp. The child writes what it found to a file without a name that both processes have open.
#include "compiler/driver/first_runs.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <memory>

#include "compiler/pipeline/executor.hpp"

namespace bip::driver {

namespace {

constexpr std::uint64_t kRuns = 16, kStepsOfRun = 10'000;
// The text of a longer run is cut.
constexpr std::size_t kMostText = 1 << 20;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

std::string text_of(std::FILE* file) {
  std::string text;
  std::rewind(file);
  char block[4096];
  while (const std::size_t got = std::fread(block, 1, sizeof block, file)) {
    text.append(block, got);
    if (text.size() > kMostText) break;
  }
  return text;
}

void detach_standard_streams() {
  const int null = ::open("/dev/null", O_RDWR);
  if (null < 0) return;
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) (void)::dup2(null, stream);
}

// In the child.
void run_all(Compilation& c, Backend backend, rt::End end, unsigned seconds, std::FILE* found) {
  Executor executor(MachineCode::Fresh);
  if (!executor.prepare(c, backend, Optimisation::O0)) return;
  ::alarm(seconds);
  std::uint64_t fewest = kStepsOfRun + 1;
  std::string best;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const File steps(std::tmpfile());
    if (steps == nullptr) return;
    rt::RunOptions options;
    options.seed = seed;
    options.has_seed = true;
    options.limit = fewest - 1;
    const rt::RunResult result = rt::run(c.lowered->image, options, steps.get(), steps.get());
    if (result.end != end || result.steps >= fewest) continue;
    fewest = result.steps;
    best = text_of(steps.get());
    if (fewest == 0) break;
  }
  std::fwrite(best.data(), 1, best.size(), found);
  std::fflush(found);
}

}  // namespace

std::optional<std::string> run_to_end(Compilation& c, Backend backend, rt::End end, unsigned seconds) {
  const File found(std::tmpfile());
  if (found == nullptr) return std::nullopt;
  std::fflush(stdout);
  std::fflush(stderr);
  const pid_t child = ::fork();
  if (child < 0) return std::nullopt;
  if (child == 0) {
    detach_standard_streams();
    run_all(c, backend, end, seconds, found.get());
    // No destructor of the parent's objects runs twice.
    ::_exit(0);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return std::nullopt;
  std::string text = text_of(found.get());
  if (text.empty()) return std::nullopt;
  return text;
}

}  // namespace bip::driver
