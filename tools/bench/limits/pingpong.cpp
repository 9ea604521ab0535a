// Pairs by hand: interaction 2i hands pair i's number over, 2i + 1 hands it back.
#include "limit.hpp"

namespace {

using limit::u32;

struct World {
  explicit World(u32 pairs) : n(pairs), away(pairs, 0), ping(pairs, 0), pong(pairs, 0) {}
  [[nodiscard]] u32 interactions() const { return 2 * n; }
  [[nodiscard]] bool is_enabled(u32 i) const { return away[i >> 1] == (i & 1); }
  void apply(u32 i) {
    const u32 pair = i >> 1;
    if ((i & 1) == 0) pong[pair] = ping[pair] + 1;
    else ping[pair] = pong[pair] + 1;
    away[pair] = static_cast<limit::u8>((i & 1) ^ 1);
  }
  static void update(limit::EnabledSet& enabled, u32 i) { enabled.replace(i, i ^ 1); }
  [[nodiscard]] limit::u64 checksum() const {
    limit::u64 sum = 0;
    for (u32 i = 0; i < n; ++i) sum += ping[i] > pong[i] ? ping[i] : pong[i];
    return sum;
  }

  u32 n;
  std::vector<limit::u8> away;
  std::vector<u32> ping, pong;
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  World world(arguments.n);
  return limit::run(world, arguments);
}
