// The broadcast by hand: interaction n is the sender with all who listen, i < n re-arms receiver i. Who listens is a
// dense list, so a broadcast is one pass over those that take part.
#include "limit.hpp"

namespace {

using limit::u32;

struct World {
  explicit World(u32 receivers)
      : n(receivers), full(receivers, 0), heard(receivers, 0), listening(receivers), armed(receivers) {
    for (u32 i = 0; i < n; ++i) listening[i] = i;
  }
  [[nodiscard]] u32 interactions() const { return n + 1; }
  [[nodiscard]] bool is_enabled(u32 i) const { return i == n || full[i] != 0; }
  void apply(u32 i) {
    if (i < n) {
      full[i] = 0;
      listening[armed++] = i;
      return;
    }
    ++sent;
    for (u32 k = 0; k < armed; ++k) {
      full[listening[k]] = 1;
      ++heard[listening[k]];
    }
    reached = armed;
    armed = 0;
  }
  void update(limit::EnabledSet& enabled, u32 i) const {
    if (i < n) {
      enabled.erase(i);
      return;
    }
    for (u32 k = 0; k < reached; ++k) enabled.insert(listening[k]);
  }
  [[nodiscard]] limit::u64 checksum() const {
    limit::u64 sum = sent;
    for (u32 h : heard) sum += h;
    return sum;
  }

  u32 n, sent = 0, reached = 0;
  std::vector<limit::u8> full;
  std::vector<u32> heard, listening;
  u32 armed;
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  World world(arguments.n);
  return limit::run(world, arguments);
}
