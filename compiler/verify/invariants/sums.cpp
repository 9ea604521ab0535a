// Sums of weights that no step changes (traps.hpp), decided bottom up on the connectors' trees: by how much does a
// choice change the sum? If choices below one node differ in that, the set is refused.
#include <algorithm>

#include "compiler/verify/invariants/traps.hpp"

namespace bip::verify {

namespace {
constexpr std::int64_t kVaries = std::int64_t{1} << 60, kDead = kVaries + 1;
}

// By how much a choice below changes the sum; kVaries if choices differ, kDead if there is none.
std::int64_t TrapFinder::delta(u32 node, u32 depth) const {
  if (depth > kMaxDepth) return kVaries;
  std::int64_t result = kDead;
  const auto join = [&](std::int64_t value) { result = result == kDead || result == value ? value : kVaries; };
  const std::span<const Edge> children = net_.children(node);
  switch (net_.nodes[node].kind) {
    case NodeKind::Port: {
      const u32 base = net_.mode_base[net_.atom_of_port[node]];
      for (const Move& move : net_.moves(node)) {
        if (is_possible(node, base + move.from)) join(weight_[base + move.to] - weight_[base + move.from]);
      }
      return result;
    }
    case NodeKind::All: {
      std::int64_t sum = 0;
      bool varies = false;
      for (const Edge& child : children) {
        const std::int64_t value = delta(child.node, depth + 1);
        if (value == kDead) return kDead;
        varies |= value == kVaries;
        if (!varies) sum += value;
      }
      return varies ? kVaries : sum;
    }
    case NodeKind::Trigger: {
      if (children.size() == 1) return delta(children[0].node, depth + 1);
      for (const Edge& child : children) {
        const std::int64_t value = delta(child.node, depth + 1);
        if (value != 0 && value != kDead) return kVaries;
      }
      return 0;
    }
    default:
      for (const Edge& child : children) {
        const std::int64_t value = delta(child.node, depth + 1);
        if (value != kDead) join(value);
      }
      return result;
  }
}

bool TrapFinder::keeps_sum(const TokenInvariant& invariant) {
  for (std::size_t k = 0; k < invariant.modes.size(); ++k) weight_[invariant.modes[k]] = weight_of(invariant, k);
  std::int64_t sum = 0;
  bool holds = true;
  std::vector<u32> todo;
  u32 last = kNoRow;
  for (u32 mode : invariant.modes) {
    // Modes are sorted, so those of an atom stand together.
    const u32 atom = net_.atom_of_mode[mode];
    if (atom == last) continue;
    last = atom;
    const std::vector<u32>& initial = net_.class_at(atom).initial;
    const u32 base = net_.mode_base[atom];
    for (u32 first : initial) holds = holds && weight_[base + first] == weight_[base + initial[0]];
    if (!initial.empty()) sum += weight_[base + initial[0]];
    for (u32 port = net_.port_base[atom]; port < net_.port_base[atom + 1]; ++port) {
      const std::int64_t change = delta(port, 0);
      if (change != 0 && change != kDead) todo.push_back(port);
    }
  }
  holds = holds && sum == invariant.total;
  // Every root above a port that changes something.
  std::vector<u32> seen;
  while (!todo.empty() && holds) {
    const u32 node = todo.back();
    todo.pop_back();
    if (is_seen_[node] != 0) continue;
    is_seen_[node] = 1;
    seen.push_back(node);
    if (net_.nodes[node].is_root) {
      const std::int64_t value = delta(node, 0);
      holds = value == 0 || value == kDead;
    }
    for (const Edge& parent : net_.parents(node)) todo.push_back(parent.node);
  }
  for (u32 node : seen) is_seen_[node] = 0;
  for (u32 mode : invariant.modes) weight_[mode] = 0;
  return holds;
}

}  // namespace bip::verify
