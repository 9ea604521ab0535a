// The lamps by hand: the maximal sets of lamps that the mains can carry, found as a careful programmer would for that
// one model: few lamps must be off, so the program searches the minimal sets of lamps to switch off. `naive` evaluates
// all 2^n - 1 interactions, and then which of the enabled ones are maximal.
#include "limit.hpp"

namespace {

using limit::u32;
using limit::u64;

struct World {
  explicit World(u32 size) : n(size), watt(size), mains(5 * size / 2 - 3), hours(size) {
    for (u32 i = 0; i < n; ++i) watt[i] = i % 4 + 1;
  }
  // Sets to leave out whose sum is at least `excess`, and without any of their lamps less than that.
  void leave_out(u32 from, u32 excess, u32 sum, u32 least, u64 set) {
    if (sum >= excess) {
      if (set == 0 || sum - least < excess) found.push_back(set);
      return;
    }
    for (u32 i = from; i < n; ++i) {
      leave_out(i + 1, excess, sum + watt[i], least < watt[i] ? least : watt[i], set | u64{1} << i);
    }
  }
  void list_limit() {
    found.clear();
    u32 total = 0;
    for (u32 w : watt) total += w;
    leave_out(0, total > mains ? total - mains : 0, 0, ~0u, 0);
  }
  void list_naive() {
    found.clear();
    std::vector<u64> enabled;
    for (u64 set = 1; set < u64{1} << n; ++set) {
      u32 sum = 0;
      for (u64 rest = set; rest != 0; rest &= rest - 1) sum += watt[static_cast<u32>(__builtin_ctzll(rest))];
      if (sum > mains) continue;
      bool is_maximal = true;
      for (u32 i = 0; i < n; ++i) is_maximal = is_maximal && ((set >> i & 1) != 0 || sum + watt[i] > mains);
      if (is_maximal) enabled.push_back(~set & ((u64{1} << n) - 1));
    }
    found = enabled;
  }
  void apply(u64 left_out) {
    for (u32 i = 0; i < n; ++i) hours[i] += 1 - (left_out >> i & 1);
  }

  u32 n;
  std::vector<u32> watt;
  u32 mains;
  std::vector<u64> hours;
  std::vector<u64> found;
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  World world(arguments.n);
  return limit::run_listed(world, arguments);
}
