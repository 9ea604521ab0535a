// The token ring by hand: interaction i hands the token from atom i to the next one.
#include "limit.hpp"

namespace {

using limit::u32;

struct World {
  explicit World(u32 size) : n(size), holding(size, 0) { holding[0] = 1; }
  [[nodiscard]] u32 interactions() const { return n; }
  [[nodiscard]] u32 after(u32 i) const { return i + 1 == n ? 0 : i + 1; }
  [[nodiscard]] bool is_enabled(u32 i) const { return (holding[i] & ~holding[after(i)] & 1) != 0; }
  void apply(u32 i) {
    holding[i] = 0;
    holding[after(i)] = 1;
    at = after(i);
  }
  void update(limit::EnabledSet& enabled, u32 i) const {
    const u32 before = i == 0 ? n - 1 : i - 1;
    enabled.put(i, is_enabled(i));
    enabled.put(before, is_enabled(before));
    enabled.put(after(i), is_enabled(after(i)));
  }
  [[nodiscard]] limit::u64 checksum() const { return at; }

  u32 n, at = 0;
  std::vector<limit::u8> holding;
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  World world(arguments.n);
  return limit::run(world, arguments);
}
