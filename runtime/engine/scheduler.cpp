// Choosing candidates: see scheduler.hpp.
#include "runtime/engine/scheduler.hpp"

#include <chrono>
#include <cstdio>

namespace bip::rt {

std::uint64_t draw_seed() {
  std::uint32_t seed = 0;
  if (std::FILE* file = std::fopen("/dev/urandom", "rb")) {
    const std::size_t read = std::fread(&seed, sizeof seed, 1, file);
    std::fclose(file);
    if (read == 1) return seed;
  }
  return static_cast<std::uint32_t>(std::chrono::steady_clock::now().time_since_epoch().count());
}

}  // namespace bip::rt
