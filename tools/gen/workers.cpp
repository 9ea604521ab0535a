// Workers are child processes. Each writes lines of results to a pipe and its current seed to shared memory. When a
// worker dies, its current seed counts as failed and a new worker continues with the next one.
#include "tools/gen/workers.hpp"

#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace bip::gen {
namespace {

// Of the processor, not of the clock: on a busy machine a model may wait for minutes.
constexpr int kSecondsPerModel = 30;
constexpr int kSecondsPerRuns = 600;

void limit_time(int seconds) {
  const itimerval limit{.it_interval = {}, .it_value = {.tv_sec = seconds, .tv_usec = 0}};
  setitimer(ITIMER_PROF, &limit, nullptr);
}

std::string death(int status) {
  if (WIFSIGNALED(status)) {
    int signal = WTERMSIG(status);
    return signal == SIGPROF ? "crash: no end in its time" : "crash: signal " + std::to_string(signal);
  }
  return "crash: exit code " + std::to_string(WEXITSTATUS(status));
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', '\x01');
  return text;
}
std::string many_lines(std::string text) {
  std::replace(text.begin(), text.end(), '\x01', '\n');
  return text;
}

/// What a worker does: its share of the seeds, batches of emitted C++ on the way.
class Worker {
 public:
  Worker(std::FILE* out, volatile std::uint64_t* current, std::size_t batch, const CheckOptions& options)
      : out_(out), current_(current), batch_(batch), options_(options) {}

  void run(std::uint64_t first, std::uint64_t end, std::uint64_t stride) {
    for (std::uint64_t seed = first; seed < end; seed += stride) {
      *current_ = seed;
      limit_time(options_.engine_runs != 0 ? kSecondsPerRuns : kSecondsPerModel);
      Counts counts;
      EmittedCase emitted;
      SupportedModel supported = supported_model(seed);
      std::string failure =
          check_model(supported.model, seed, options_, counts, options_.emit_cpp ? &emitted : nullptr);
      limit_time(0);
      std::fprintf(out_, "M %llu %llu %llu\n", static_cast<unsigned long long>(counts.oracle.states),
                   static_cast<unsigned long long>(counts.oracle.too_large),
                   static_cast<unsigned long long>(counts.in_columns));
      tell(counts.engines);
      if (supported.is_plain) std::fprintf(out_, "U 1\n");
      if (!failure.empty()) {
        report({seed, failure});
      } else if (options_.emit_cpp) {
        cases_.push_back(std::move(emitted));
        if (cases_.size() >= batch_) flush();
      }
      std::fflush(out_);
    }
    flush();
    std::fflush(out_);
  }

 private:
  void report(const Failure& f) {
    std::fprintf(out_, "F %llu %s\n", static_cast<unsigned long long>(f.seed), one_line(f.what).c_str());
  }
  void tell(const EngineCounts& counts) {
    std::fprintf(out_, "R %llu %llu %llu %llu %llu\n", static_cast<unsigned long long>(counts.runs),
                 static_cast<unsigned long long>(counts.steps), static_cast<unsigned long long>(counts.in_parts),
                 static_cast<unsigned long long>(counts.with_known), static_cast<unsigned long long>(counts.timed));
  }
  void flush() {
    if (cases_.empty()) return;
    EngineCounts counts;
    for (const Failure& f : check_emitted(cases_, options_, "batch" + std::to_string(cases_.front().seed), counts))
      report(f);
    tell(counts);
    std::fprintf(out_, "E %zu\n", cases_.size());
    cases_.clear();
  }

  std::FILE* out_;
  volatile std::uint64_t* current_;
  std::size_t batch_;
  const CheckOptions& options_;
  std::vector<EmittedCase> cases_;
};

void read_results(std::FILE* in, Totals& totals) {
  char* line = nullptr;
  std::size_t capacity = 0;
  for (ssize_t n; (n = getline(&line, &capacity, in)) > 0;) {
    if (line[n - 1] == '\n') line[n - 1] = 0;
    char* rest = nullptr;
    std::uint64_t first = std::strtoull(line + 2, &rest, 10);
    if (line[0] == 'M') {
      ++totals.models;
      totals.counts.oracle.states += first;
      totals.counts.oracle.too_large += std::strtoull(rest, &rest, 10);
      totals.counts.in_columns += std::strtoull(rest, nullptr, 10);
    } else if (line[0] == 'R') {
      const std::uint64_t steps = std::strtoull(rest, &rest, 10);
      const std::uint64_t in_parts = std::strtoull(rest, &rest, 10);
      const std::uint64_t with_known = std::strtoull(rest, &rest, 10);
      totals.counts.engines.add({first, steps, in_parts, with_known, std::strtoull(rest, nullptr, 10)});
    } else if (line[0] == 'E') {
      totals.emitted += first;
    } else if (line[0] == 'U') {
      ++totals.unsupported;
    } else if (line[0] == 'F') {
      totals.failures.push_back({first, many_lines(rest + 1)});
    }
  }
  std::free(line);
}

struct Slice {
  std::uint64_t next = 0;
  pid_t pid = 0;
  std::FILE* results = nullptr;
};

}  // namespace

Totals check_seeds(std::uint64_t first, std::uint64_t count, int jobs, std::size_t batch, const CheckOptions& options) {
  auto workers = static_cast<std::uint64_t>(std::max(1, jobs));
  void* shared =
      mmap(nullptr, workers * sizeof(std::uint64_t), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  auto* current = static_cast<volatile std::uint64_t*>(shared);
  std::vector<Slice> slices(workers);
  Totals totals;
  auto start = [&](std::size_t w) {
    Slice& slice = slices[w];
    // A file, not a pipe: a pipe must be read while the workers write.
    slice.results = std::tmpfile();
    std::fflush(nullptr);
    slice.pid = fork();
    if (slice.pid != 0) return;
    Worker(slice.results, &current[w], batch, options).run(slice.next, first + count, workers);
    std::_Exit(0);
  };
  for (std::size_t w = 0; w < workers; ++w) {
    slices[w].next = first + w;
    start(w);
  }
  for (std::size_t running = workers; running > 0;) {
    int status = 0;
    pid_t pid = wait(&status);
    auto slice = std::find_if(slices.begin(), slices.end(), [&](const Slice& s) { return s.pid == pid; });
    if (slice == slices.end()) break;
    std::rewind(slice->results);
    read_results(slice->results, totals);
    std::fclose(slice->results);
    auto w = static_cast<std::size_t>(slice - slices.begin());
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
      --running;
      continue;
    }
    ++totals.models;
    totals.failures.push_back({current[w], death(status)});
    slice->next = current[w] + workers;
    start(w);
  }
  munmap(shared, workers * sizeof(std::uint64_t));
  std::sort(totals.failures.begin(), totals.failures.end(),
            [](const Failure& a, const Failure& b) { return a.seed < b.seed; });
  return totals;
}

std::string check_isolated(const Description& model, std::uint64_t seed, const CheckOptions& options) {
  std::FILE* results = std::tmpfile();
  std::fflush(nullptr);
  pid_t pid = fork();
  if (pid == 0) {
    limit_time(options.engine_runs != 0 ? kSecondsPerRuns : kSecondsPerModel);
    // What a crashing compiler says about itself would repeat at every attempt.
    std::FILE* quiet = std::freopen("/dev/null", "w", stderr);
    if (quiet == nullptr) std::_Exit(1);
    Counts counts;
    EmittedCase emitted;
    std::string failure = check_model(model, seed, options, counts, options.emit_cpp ? &emitted : nullptr);
    if (failure.empty() && options.emit_cpp) {
      for (const Failure& f : check_emitted({emitted}, options, "alone" + std::to_string(seed), counts.engines))
        failure = f.what;
    }
    std::fputs(failure.c_str(), results);
    std::fflush(results);
    std::_Exit(0);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  std::string text;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    std::rewind(results);
    char buffer[4096];
    for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, results)) > 0;) text.append(buffer, n);
  } else {
    text = death(status);
  }
  std::fclose(results);
  return text;
}

}  // namespace bip::gen
