// What a good programmer would write for the token ring alone: one array, the place of the token, no engine. The figure
// that tools/bench/spine prints beside bipc's: nobody can be faster by much.
//
//   limit_ring N STEPS      prints nanoseconds an interaction
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::size_t n = std::strtoull(argv[1], nullptr, 10);
  const std::uint64_t steps = std::strtoull(argv[2], nullptr, 10);
  std::vector<std::uint8_t> holding(n, 0);
  holding[0] = 1;
  std::size_t at = 0;
  std::uint64_t random = 1, taken = 0;
  const auto start = std::chrono::steady_clock::now();
  for (std::uint64_t step = 0; step < steps; ++step) {
    const std::size_t next = at + 1 == n ? 0 : at + 1;
    // A policy's random number, drawn although there is one candidate only, as an engine does.
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    if (holding[at] == 0 || holding[next] != 0) break;
    holding[at] = 0;
    holding[next] = 1;
    at = next;
    taken += random & 1;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::fprintf(stderr, "%llu\n", static_cast<unsigned long long>(taken));
  std::printf("%.2f\n", seconds * 1e9 / static_cast<double>(steps));
}
