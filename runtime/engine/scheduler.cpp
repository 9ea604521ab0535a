// Choosing candidates: see scheduler.hpp.
#include "runtime/engine/scheduler.hpp"

#include <chrono>
#include <cstdio>

namespace bip::rt {

bool Scheduler::find_decided(const Core& core, EnabledSet::Position& at) {
  const std::uint64_t count = core.candidate_count();
  BIP_ASSERT(core.enabled().has(at), "interaction {} is no candidate", at.interaction);
  if (core.partial().is_decided(at.interaction)) return true;
  std::uint64_t k = core.enabled().number(at);
  for (std::uint64_t tried = 1; tried < count; ++tried) {
    k = k + 1 == count ? 0 : k + 1;
    at = core.position(k);
    if (core.partial().is_decided(at.interaction)) return true;
  }
  return false;
}

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
