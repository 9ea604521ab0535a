// The token ring by hand: flat arrays and an exact set of enabled interactions (dense array and positions) from which
// one is drawn uniformly, as an engine must; no tables, no watchers, no trace. tools/bench/spine prints it beside
// bipc's figure.
//
//   limit_ring N STEPS      prints nanoseconds an interaction
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

constexpr std::uint32_t kAbsent = 0xffffffffu;

/// Interaction i hands the token from atom i to the next one.
struct Ring {
  explicit Ring(std::uint32_t n) : holding(n, 0), position(n, kAbsent) { holding[0] = 1; }

  void update(std::uint32_t i) {
    const std::uint32_t next = i + 1 == holding.size() ? 0 : i + 1;
    const bool is_enabled = holding[i] != 0 && holding[next] == 0;
    if (is_enabled == (position[i] != kAbsent)) return;
    if (is_enabled) {
      position[i] = static_cast<std::uint32_t>(enabled.size());
      enabled.push_back(i);
      return;
    }
    enabled[position[i]] = enabled.back();
    position[enabled.back()] = position[i];
    enabled.pop_back();
    position[i] = kAbsent;
  }
  void fire(std::uint32_t i) {
    const auto n = static_cast<std::uint32_t>(holding.size());
    const std::uint32_t next = i + 1 == n ? 0 : i + 1;
    holding[i] = 0;
    holding[next] = 1;
    update(i == 0 ? n - 1 : i - 1);
    update(i);
    update(next);
  }

  std::vector<std::uint8_t> holding;
  std::vector<std::uint32_t> enabled, position;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  Ring ring(static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10)));
  const std::uint64_t steps = std::strtoull(argv[2], nullptr, 10);
  for (std::uint32_t i = 0; i < ring.holding.size(); ++i) ring.update(i);
  std::uint64_t random = 1;
  const auto start = std::chrono::steady_clock::now();
  for (std::uint64_t step = 0; step < steps && !ring.enabled.empty(); ++step) {
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    const std::uint64_t drawn = (random >> 32) * ring.enabled.size() >> 32;
    ring.fire(ring.enabled[drawn]);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("%.2f\n", seconds * 1e9 / static_cast<double>(steps));
}
