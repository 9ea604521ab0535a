// Philosophers by hand: interaction i takes both forks of philosopher i, n + i gives them back.
#include "limit.hpp"

namespace {

using limit::u32;
using limit::u8;

struct World {
  explicit World(u32 size) : n(size), eats(size, 0), taken(size, 0), meals(size, 0) {}
  [[nodiscard]] u32 interactions() const { return 2 * n; }
  [[nodiscard]] u32 after(u32 i) const { return i + 1 == n ? 0 : i + 1; }
  [[nodiscard]] u32 before(u32 i) const { return i == 0 ? n - 1 : i - 1; }
  [[nodiscard]] bool can_take(u32 i) const { return (eats[i] | taken[i] | taken[after(i)]) == 0; }
  [[nodiscard]] bool is_enabled(u32 i) const { return i < n ? can_take(i) : eats[i - n] != 0; }
  void apply(u32 i) {
    const u8 now = i < n ? 1 : 0;
    const u32 who = i < n ? i : i - n;
    eats[who] = taken[who] = taken[after(who)] = now;
    meals[who] += now;
  }
  void update(limit::EnabledSet& enabled, u32 i) const {
    const u32 who = i < n ? i : i - n;
    const u32 left = before(who), right = after(who);
    if (i < n) {
      enabled.replace(i, n + i);
      if (enabled.contains(left)) enabled.erase(left);
      if (enabled.contains(right)) enabled.erase(right);
      return;
    }
    enabled.replace(i, who);
    if (can_take(left) && !enabled.contains(left)) enabled.insert(left);
    if (can_take(right) && !enabled.contains(right)) enabled.insert(right);
  }
  [[nodiscard]] limit::u64 checksum() const {
    limit::u64 sum = 0;
    for (u32 m : meals) sum += m;
    return sum;
  }

  u32 n;
  std::vector<u8> eats, taken;
  std::vector<u32> meals;
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  World world(arguments.n);
  return limit::run(world, arguments);
}
