// The tree by hand: flattened, the maximum of all leaves in one pass and back in another. `naive` walks the tree of
// connectors up and down through pointers, as classic engines do.
#include "limit.hpp"

namespace {

using limit::u32;

struct Node {
  Node *a = nullptr, *b = nullptr;
  u32 leaf = 0;
  u32 best = 0;
  bool is_enabled = false;
};

void up(Node& node, const std::vector<u32>& leaves) {
  if (node.a == nullptr) {
    node.best = leaves[node.leaf];
    node.is_enabled = true;
    return;
  }
  up(*node.a, leaves);
  up(*node.b, leaves);
  node.is_enabled = node.a->is_enabled && node.b->is_enabled;
  node.best = node.a->best > node.b->best ? node.a->best : node.b->best;
}

void down(Node& node, std::vector<u32>& leaves) {
  if (node.a == nullptr) {
    leaves[node.leaf] = node.best + 1;
    return;
  }
  node.a->best = node.b->best = node.best;
  down(*node.a, leaves);
  down(*node.b, leaves);
}

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  const u32 n = arguments.n;
  std::vector<u32> leaves(n);
  for (u32 i = 0; i < n; ++i) leaves[i] = i;
  if (arguments.naive) {
    std::vector<Node> nodes(2 * n - 1);
    for (u32 i = 0; i < 2 * n - 1; ++i) {
      if (i + 1 < n) nodes[i].a = &nodes[2 * i + 1], nodes[i].b = &nodes[2 * i + 2];
      else nodes[i].leaf = i + 1 - n;
    }
    const double start = limit::cpu_seconds();
    for (limit::u64 step = 0; step < arguments.steps; ++step) {
      up(nodes[0], leaves);
      if (!nodes[0].is_enabled) return 1;
      down(nodes[0], leaves);
    }
    limit::report(arguments.steps, limit::cpu_seconds() - start, leaves[0]);
    return 0;
  }
  const double start = limit::cpu_seconds();
  for (limit::u64 step = 0; step < arguments.steps; ++step) {
    u32 best = 0;
    for (u32 value : leaves) best = value > best ? value : best;
    for (u32& value : leaves) value = best + 1;
    asm volatile("" ::: "memory");
  }
  limit::report(arguments.steps, limit::cpu_seconds() - start, leaves[0]);
}
