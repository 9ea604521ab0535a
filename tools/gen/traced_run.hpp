// One run of an image and everything that it says: candidates and choices in the reference engine's format, run-time
// errors, the JSON trace, how it ended. Needs the runtime only, so that emitted programs of a batch use the same text.
#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"

namespace bip::gen {

struct RunSpec {
  std::uint64_t seed = 0;
  std::uint64_t steps = 0;
  rt::Policy policy = rt::Policy::Uniform;
  rt::TraceFormat format = rt::TraceFormat::Bip2;
  bool maximal_progress = true;
};
/// What every executor runs: three policies, one of them with the JSON trace.
inline RunSpec run_spec(int number, std::uint64_t seed, std::uint64_t steps) {
  switch (number) {
    case 0: return {.seed = seed, .steps = steps, .policy = rt::Policy::Uniform, .format = rt::TraceFormat::Bip2};
    case 1: return {.seed = seed + 1, .steps = steps, .policy = rt::Policy::First, .format = rt::TraceFormat::Steps};
    default: break;
  }
  return {.seed = seed + 2, .steps = steps, .policy = rt::Policy::Fair, .format = rt::TraceFormat::Bip2,
          .maximal_progress = number != 3};
}
inline constexpr int kRunSpecs = 4;

inline std::string traced_run(const rt::Image& image, const RunSpec& spec) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* out = open_memstream(&text, &size);
  rt::RunOptions options;
  options.seed = spec.seed;
  options.has_seed = true;
  options.limit = spec.steps;
  // A state with thousands of interactions has as many lines in the bip2 trace: a few steps of it say enough.
  rt::Core first(image, {.progress = spec.maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off});
  if (first.initialize() && first.candidate_count() > 1000) options.limit = std::min<std::uint64_t>(spec.steps, 2);
  options.policy = spec.policy;
  options.format = spec.format;
  options.maximal_progress = spec.maximal_progress;
  int json = -1;
  if (spec.format == rt::TraceFormat::Steps) {
    json = memfd_create("trace", 0);
    options.trace_path = "/proc/self/fd/" + std::to_string(json);
  }
  rt::RunResult result = rt::run(image, options, out, out);
  std::fclose(out);
  std::string all(text, size);
  std::free(text);
  if (json >= 0) {
    char buffer[4096];
    lseek(json, 0, SEEK_SET);
    for (ssize_t n; (n = read(json, buffer, sizeof buffer)) > 0;) all.append(buffer, static_cast<std::size_t>(n));
    close(json);
  }
  return all + "end " + std::to_string(static_cast<int>(result.end)) + " steps " + std::to_string(result.steps) + " exit " +
         std::to_string(result.exit_code) + "\n";
}

}  // namespace bip::gen
