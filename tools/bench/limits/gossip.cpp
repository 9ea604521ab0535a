// The gossip by hand: interaction e < n is node e's first edge, n + e its second one. After a step the edges from and
// to the node that has counted are looked at again.
#include "limit.hpp"

namespace {

using limit::u32;

struct World {
  explicit World(u32 size) : n(size), count(size, 0), told(size, 0), target(2 * size), into(2 * size) {
    for (u32 i = 0; i < n; ++i) {
      target[i] = static_cast<u32>((limit::u64{i} * 7919 + 13) % n);
      target[n + i] = static_cast<u32>((limit::u64{i} * 1229 + 7) % n);
      into[target[i]] = i;
      into[n + target[n + i]] = n + i;
    }
  }
  [[nodiscard]] u32 interactions() const { return 2 * n; }
  [[nodiscard]] u32 from(u32 edge) const { return edge < n ? edge : edge - n; }
  [[nodiscard]] bool is_enabled(u32 edge) const { return count[from(edge)] < count[target[edge]] + 4; }
  void apply(u32 edge) { told[target[edge]] = ++count[from(edge)]; }
  void update(limit::EnabledSet& enabled, u32 edge) const {
    const u32 node = from(edge);
    enabled.put(node, is_enabled(node));
    enabled.put(n + node, is_enabled(n + node));
    enabled.put(into[node], is_enabled(into[node]));
    enabled.put(into[n + node], is_enabled(into[n + node]));
  }
  [[nodiscard]] limit::u64 checksum() const {
    limit::u64 sum = 0;
    for (u32 c : count) sum += c;
    for (u32 t : told) sum ^= t;
    return sum;
  }

  u32 n;
  std::vector<u32> count, told, target, into;
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  World world(arguments.n);
  return limit::run(world, arguments);
}
