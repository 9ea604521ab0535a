// The tree of equal givers by hand: the sets of n/2 givers are listed at each step, in order, as bit masks; all givers
// of the set that is drawn add the sum. `naive` looks at all 2^n sets.
#include "limit.hpp"

namespace {

using limit::u32;
using limit::u64;

struct World {
  explicit World(u32 size) : n(size), total(size, 0) {}
  // Of the masks with n/2 bits, each from the one before (the next larger number with as many bits).
  void list_limit() {
    found.clear();
    for (u64 set = (u64{1} << (n / 2)) - 1; set < u64{1} << n;) {
      found.push_back(set);
      const u64 low = set & (~set + 1), next = set + low;
      set = next | (((set ^ next) >> 2) / low);
    }
  }
  void list_naive() {
    found.clear();
    for (u64 set = 1; set < u64{1} << n; ++set) {
      if (static_cast<u32>(__builtin_popcountll(set)) == n / 2) found.push_back(set);
    }
  }
  void apply(u64 set) {
    for (u32 i = 0; i < n; ++i) total[i] += (set >> i & 1) != 0 ? n / 2 : 0;
  }

  u32 n;
  std::vector<u64> total, found;
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  World world(arguments.n);
  return limit::run_listed(world, arguments);
}
