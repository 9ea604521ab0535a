// See place_invariant_checker.hpp.
#include "compiler/verify/invariants/place_invariant_checker.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {
// Beside any change of the sum: the choices below a node differ; there is no choice.
constexpr std::int64_t kVaries = std::int64_t{1} << 60, kDead = kVaries + 1;
}  // namespace

PlaceInvariantChecker::PlaceInvariantChecker(const Net& net, const ModeReachability& reachable)
    : net_(net), reachable_(reachable), weight_(net.mode_count(), 0), is_visited_(net.graph.nodes.size(), 0) {}

// Returns by how much each choice below the node changes the sum; kVaries if choices differ, kDead if there is none.
std::int64_t PlaceInvariantChecker::change(u32 node, u32 depth) const {
  if (depth > kMaxDepth) return kVaries;
  std::int64_t result = kDead;
  const auto join = [&](std::int64_t value) { result = result == kDead || result == value ? value : kVaries; };
  const std::span<const Edge> children = net_.graph.children(node);
  switch (net_.graph.nodes[node].kind) {
    // A port: all its possible moves must change the sum alike.
    case ConnectorNodeKind::Port: {
      const u32 base = net_.mode_base[net_.graph.atom_of_port[node]];
      for (const Move& move : net_.moves(node)) {
        if (reachable_.is_on(base + move.from) && reachable_.in_context(node))
          join(weight_[base + move.to] - weight_[base + move.from]);
      }
      return result;
    }
    // A rendezvous: the sum over all children.
    case ConnectorNodeKind::All: {
      std::int64_t sum = 0;
      bool varies = false;
      for (const Edge& child : children) {
        const std::int64_t value = change(child.node, depth + 1);
        if (value == kDead) return kDead;
        varies |= value == kVaries;
        if (!varies) sum += value;
      }
      return varies ? kVaries : sum;
    }
    // Any subset of the children with a trigger: only 0 each is the same for all subsets.
    case ConnectorNodeKind::Trigger: {
      if (children.size() == 1) return change(children[0].node, depth + 1);
      for (const Edge& child : children) {
        const std::int64_t value = change(child.node, depth + 1);
        if (value != 0 && value != kDead) return kVaries;
      }
      return 0;
    }
    // Exactly one child.
    case ConnectorNodeKind::Any:
      for (const Edge& child : children) {
        const std::int64_t value = change(child.node, depth + 1);
        if (value != kDead) join(value);
      }
      return result;
  }
  BIP_UNREACHABLE("kind of a node");
}

// Of several initial modes of one atom each must have the same weight.
bool PlaceInvariantChecker::holds_initially(const TokenInvariant& invariant) const {
  std::int64_t sum = 0;
  u32 last = kNoRow;
  for (u32 mode : invariant.modes) {
    const u32 atom = net_.atom_of_mode[mode];
    if (atom == last) continue;
    last = atom;
    const std::vector<u32>& initial = net_.class_at(atom).initial;
    const u32 base = net_.mode_base[atom];
    for (u32 first : initial) {
      if (weight_[base + first] != weight_[base + initial[0]]) return false;
    }
    if (!initial.empty()) sum += weight_[base + initial[0]];
  }
  return sum == invariant.total;
}

// Every root above a port that changes the sum changes it by nothing.
bool PlaceInvariantChecker::steps_above_keep_sum(std::vector<u32> ports) {
  std::vector<u32>& todo = ports;
  std::vector<u32> visited;
  bool keeps = true;
  while (!todo.empty() && keeps) {
    const u32 node = todo.back();
    todo.pop_back();
    if (is_visited_[node] != 0) continue;
    is_visited_[node] = 1;
    visited.push_back(node);
    if (net_.graph.nodes[node].is_root) {
      const std::int64_t value = change(node, 0);
      keeps = value == 0 || value == kDead;
    }
    for (const Edge& parent : net_.graph.parents(node)) todo.push_back(parent.node);
  }
  for (u32 node : visited) is_visited_[node] = 0;
  return keeps;
}

bool PlaceInvariantChecker::holds(const TokenInvariant& invariant) {
  // Modes are sorted, so those of an atom stand together.
  BIP_ASSERT(std::is_sorted(invariant.modes.begin(), invariant.modes.end()), "{} modes", invariant.modes.size());
  BIP_ASSERT(invariant.weights.empty() || invariant.weights.size() == invariant.modes.size(), "{} weights, {} modes",
             invariant.weights.size(), invariant.modes.size());
  for (std::size_t k = 0; k < invariant.modes.size(); ++k) weight_[invariant.modes[k]] = weight_of(invariant, k);
  bool result = holds_initially(invariant);
  if (result) {
    std::vector<u32> changing;
    u32 last = kNoRow;
    for (u32 mode : invariant.modes) {
      const u32 atom = net_.atom_of_mode[mode];
      if (atom == last) continue;
      last = atom;
      for (u32 port = net_.graph.port_base[atom]; port < net_.graph.port_base[atom + 1]; ++port) {
        const std::int64_t value = change(port, 0);
        if (value != 0 && value != kDead) changing.push_back(port);
      }
    }
    result = steps_above_keep_sum(std::move(changing));
  }
  for (u32 mode : invariant.modes) weight_[mode] = 0;
  return result;
}

}  // namespace bip::verify
