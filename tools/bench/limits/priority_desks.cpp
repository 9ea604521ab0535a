// Desks by hand, four interactions each: 0 runs the urgent task, 1 the other one (only if the urgent one is not ready),
// 2 and 3 wake them.
#include "limit.hpp"

namespace {

using limit::u32;

struct World {
  explicit World(u32 desks) : n(desks), ready(desks, 3), runs(2 * desks, 0) {}
  [[nodiscard]] u32 interactions() const { return 4 * n; }
  [[nodiscard]] bool is_enabled(u32 i) const {
    const u32 tasks = ready[i >> 2];
    switch (i & 3) {
      case 0: return (tasks & 1) != 0;
      case 1: return tasks == 2;
      case 2: return (tasks & 1) == 0;
      default: return (tasks & 2) == 0;
    }
  }
  void apply(u32 i) {
    const u32 task = i & 1, desk = i >> 2;
    ready[desk] = static_cast<limit::u8>(ready[desk] ^ (1u << task));
    runs[2 * desk + task] += (i & 2) == 0 ? 1 : 0;
  }
  void update(limit::EnabledSet& enabled, u32 i) const {
    enabled.replace(i, i ^ 2);
    const u32 other = (i & ~3u) + 1;
    if ((i & 1) == 0) enabled.put(other, is_enabled(other));
    // The other task woke, but the urgent one is ready: hidden at once.
    else if ((i & 2) != 0 && !is_enabled(other)) enabled.erase(other);
  }
  [[nodiscard]] limit::u64 checksum() const {
    limit::u64 sum = 0;
    for (u32 r : runs) sum += r;
    return sum;
  }

  u32 n;
  std::vector<limit::u8> ready;
  std::vector<u32> runs;
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  World world(arguments.n);
  return limit::run(world, arguments);
}
