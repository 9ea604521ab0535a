// A sender that hands its number to all n receivers, and re-arms no port: interaction 0 is the whole broadcast, 1
// counts the sender's number up, in turns.
#include "limit.hpp"

namespace {

using limit::u32;

struct World {
  explicit World(u32 receivers) : n(receivers), heard(receivers, 0) {}
  [[nodiscard]] u32 interactions() const { return 2; }
  [[nodiscard]] bool is_enabled(u32 i) const { return is_ready == (i == 0); }
  void apply(u32 i) {
    is_ready = i == 1;
    if (i == 1) {
      ++number;
      return;
    }
    for (u32 k = 0; k < n; ++k) heard[k] += number;
  }
  void update(limit::EnabledSet& enabled, u32 i) const { enabled.replace(i, 1 - i); }
  [[nodiscard]] limit::u64 checksum() const {
    limit::u64 sum = number;
    for (u32 h : heard) sum += h;
    return sum;
  }

  u32 n, number = 0;
  bool is_ready = true;
  std::vector<u32> heard;
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  World world(arguments.n);
  return limit::run(world, arguments);
}
