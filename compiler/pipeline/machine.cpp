// See machine.hpp. Reads /proc and /sys on Linux; elsewhere a default is used.
#include "compiler/pipeline/machine.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <thread>

namespace bip::pipeline {

namespace {

constexpr std::uint64_t kGuess = 2000000000;

// The number in a file of /sys; `otherwise` if there is none ("max").
std::uint64_t number_in(const char* path, std::uint64_t otherwise) {
  std::ifstream in(path);
  std::uint64_t value = 0;
  return in >> value ? value : otherwise;
}

}  // namespace

std::uint32_t processors() { return std::max(1u, std::thread::hardware_concurrency()); }

std::uint64_t available_memory() {
  std::uint64_t available = 0;
  std::ifstream in("/proc/meminfo");
  for (std::string key; in >> key;) {
    if (key == "MemAvailable:" && in >> available) break;
  }
  if (available == 0) return kGuess;
  available *= 1024;
  constexpr std::uint64_t kNone = ~std::uint64_t{0};
  const std::uint64_t allowed = number_in("/sys/fs/cgroup/memory.max", kNone);
  if (allowed == kNone) return available;
  const std::uint64_t used = number_in("/sys/fs/cgroup/memory.current", 0);
  return std::min(available, allowed > used ? allowed - used : 0);
}

}  // namespace bip::pipeline
