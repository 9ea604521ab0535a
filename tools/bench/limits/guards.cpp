// Stores by hand: interaction i moves a piece from store i to the next one; only three guards can change.
#include "limit.hpp"

namespace {

using limit::u32;

struct World {
  explicit World(u32 size) : n(size), level(size, 2) {}
  [[nodiscard]] u32 interactions() const { return n; }
  [[nodiscard]] u32 after(u32 i) const { return i + 1 == n ? 0 : i + 1; }
  [[nodiscard]] bool is_enabled(u32 i) const { return level[i] > 0 && level[after(i)] < 4; }
  void apply(u32 i) {
    --level[i];
    ++level[after(i)];
  }
  void update(limit::EnabledSet& enabled, u32 i) const {
    const u32 before = i == 0 ? n - 1 : i - 1;
    enabled.put(before, is_enabled(before));
    enabled.put(i, is_enabled(i));
    enabled.put(after(i), is_enabled(after(i)));
  }
  [[nodiscard]] limit::u64 checksum() const {
    limit::u64 sum = 0;
    for (int l : level) sum += static_cast<limit::u64>(l);
    return sum;
  }

  u32 n;
  std::vector<int> level;
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  World world(arguments.n);
  return limit::run(world, arguments);
}
