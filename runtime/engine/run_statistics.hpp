// What `--stats` prints at the end of a run: time per step, sizes of the enabled sets, work of searches, memory.
#pragma once
#include <algorithm>
#include <cstdint>
#include <cstdio>

#include "runtime/core/core.hpp"

namespace bip::rt {

/// How many candidates the visited states had: of every state, or of a sample where compiled steps follow each other.
struct EnabledSizes {
  u64 samples = 0, sum = 0, least = 0, most = 0;
  void add(u64 count) {
    least = samples == 0 ? count : std::min(least, count);
    most = std::max(most, count);
    sum += count;
    ++samples;
  }
};

/// Prints the statistics of `steps` steps, without the initial state, that took so many seconds.
void print_run_statistics(std::FILE* err, const Core& core, const EnabledSizes& sizes, std::uint64_t steps,
                          double seconds, double cpu_seconds);

}  // namespace bip::rt
