// See traps.hpp. A port "may put nothing" if one of its possible moves ends outside the set; a step is bad if every
// port in it may put nothing and one of them leaves the set.
#include "compiler/verify/invariants/traps.hpp"

#include <algorithm>

namespace bip::verify {

TrapFinder::TrapFinder(const Net& net, const ModeReachability& reachable)
    : net_(net),
      reachable_(reachable),
      in_large_(net.mode_count(), 0),
      in_set_(net.mode_count(), 0),
      weight_(net.mode_count(), 0),
      is_seen_(net.nodes.size(), 0) {}

void TrapFinder::put(u32 mode) {
  if (in_set_[mode] != 0) return;
  in_set_[mode] = 1;
  set_.push_back(mode);
}
void TrapFinder::clear() {
  for (u32 mode : set_) in_set_[mode] = 0;
  set_.clear();
}

// Too deep counts as yes: then fewer sets are traps, and what is said of the rest stays true.
bool TrapFinder::may_put_nothing(u32 node, u32 depth) const {
  if (depth > kMaxDepth) return true;
  const auto below = [&](const Edge& child) { return may_put_nothing(child.node, depth + 1); };
  const std::span<const Edge> children = net_.children(node);
  switch (net_.nodes[node].kind) {
    case NodeKind::Port: {
      const u32 base = net_.mode_base[net_.atom_of_port[node]];
      for (const Move& move : net_.moves(node)) {
        if (in_set_[base + move.to] == 0 && is_possible(node, base + move.from)) return true;
      }
      return false;
    }
    case NodeKind::All: return std::all_of(children.begin(), children.end(), below);
    case NodeKind::Trigger:
      return std::any_of(children.begin(), children.end(),
                         [&](const Edge& child) { return child.is_trigger && below(child); });
    default: return std::any_of(children.begin(), children.end(), below);
  }
}

bool TrapFinder::others_may_put_nothing(u32 parent, const Edge& edge_up, u32 child) const {
  const std::span<const Edge> children = net_.children(parent);
  switch (net_.nodes[parent].kind) {
    case NodeKind::All:
      return std::all_of(children.begin(), children.end(),
                         [&](const Edge& other) { return other.node == child || may_put_nothing(other.node, 0); });
    case NodeKind::Trigger:
      return edge_up.is_trigger || std::any_of(children.begin(), children.end(), [&](const Edge& other) {
               return other.is_trigger && other.node != child && may_put_nothing(other.node, 0);
             });
    default: return true;
  }
}

// Is there a step with this node in which everybody else may put nothing?
bool TrapFinder::is_in_bad_context(u32 node, u32 depth) const {
  if (net_.nodes[node].is_root || depth > kMaxDepth) return true;
  for (const Edge& parent : net_.parents(node)) {
    if (others_may_put_nothing(parent.node, parent, node) && is_in_bad_context(parent.node, depth + 1)) return true;
  }
  return false;
}

bool TrapFinder::leaves_set(u32 mode) const {
  const u32 atom = net_.atom_of_mode[mode];
  const u32 base = net_.mode_base[atom];
  for (const PortMove& move : net_.moves_out(mode)) {
    const u32 port = net_.port_base[atom] + move.port;
    if (in_set_[base + move.other] != 0 || !is_possible(port, mode)) continue;
    if (is_in_bad_context(port, 0)) return true;
  }
  return false;
}

bool TrapFinder::is_trap() const {
  return std::none_of(set_.begin(), set_.end(), [&](u32 mode) { return leaves_set(mode); });
}

bool TrapFinder::holds_trap(const std::vector<u32>& modes) {
  clear();
  for (u32 mode : modes) put(mode);
  const bool holds = is_trap();
  bool is_marked = false;
  for (std::size_t k = 0; k < set_.size() && !is_marked; ++k) {
    const u32 atom = net_.atom_of_mode[set_[k]];
    const std::vector<u32>& initial = net_.class_at(atom).initial;
    is_marked = !initial.empty() && std::all_of(initial.begin(), initial.end(),
                                                [&](u32 mode) { return in_set_[net_.mode_base[atom] + mode] != 0; });
  }
  clear();
  return holds && is_marked;
}

std::vector<TokenInvariant> TrapFinder::those_that_hold(const std::vector<TokenInvariant>& candidates) {
  std::vector<TokenInvariant> result;
  for (const TokenInvariant& one : candidates) {
    if (one.kind == InvariantKind::Trap ? holds_trap(one.modes) : keeps_sum(one)) result.push_back(one);
  }
  return result;
}

// What it costs (modes, weighted by the ways out of them) that the node always puts something; kImpossible within the
// largest trap. With `apply` they are put into the set.
std::uint64_t TrapFinder::make_putter(u32 node, bool apply, u32 depth) {
  if (depth > kMaxDepth) return kImpossible;
  const std::span<const Edge> children = net_.children(node);
  std::uint64_t cost = 0;
  switch (net_.nodes[node].kind) {
    case NodeKind::Port: {
      const u32 base = net_.mode_base[net_.atom_of_port[node]];
      for (const Move& move : net_.moves(node)) {
        const u32 to = base + move.to;
        if (in_set_[to] != 0 || !is_possible(node, base + move.from)) continue;
        if (in_large_[to] == 0) return kImpossible;
        cost += 1 + net_.moves_out(to).size();
        if (apply) put(to);
      }
      return cost;
    }
    case NodeKind::All: {
      std::uint64_t best = kImpossible;
      u32 which = kNoRow;
      for (const Edge& child : children) {
        const std::uint64_t of_child = make_putter(child.node, false, depth + 1);
        if (of_child < best) {
          best = of_child;
          which = child.node;
        }
      }
      if (apply && which != kNoRow) make_putter(which, true, depth + 1);
      return best;
    }
    default:
      for (const Edge& child : children) {
        if (net_.nodes[node].kind == NodeKind::Trigger && !child.is_trigger) continue;
        cost += make_putter(child.node, apply, depth + 1);
      }
      return std::min(cost, kImpossible);
  }
}

// What it costs that in every step with this node somebody else puts something.
std::uint64_t TrapFinder::protect(u32 node, bool apply, u32 depth) {
  if (net_.nodes[node].is_root || depth > kMaxDepth) return kImpossible;
  std::uint64_t total = 0;
  for (const Edge& parent : net_.parents(node)) {
    if (!others_may_put_nothing(parent.node, parent, node) || !is_in_bad_context(parent.node, depth + 1)) continue;
    const NodeKind kind = net_.nodes[parent.node].kind;
    std::uint64_t best = protect(parent.node, false, depth + 1);
    u32 sibling = kNoRow;
    bool all_triggers = false;
    if (kind == NodeKind::All) {
      for (const Edge& other : net_.children(parent.node)) {
        if (other.node == node) continue;
        const std::uint64_t cost = make_putter(other.node, false, 0);
        if (cost < best) {
          best = cost;
          sibling = other.node;
        }
      }
    } else if (kind == NodeKind::Trigger && !parent.is_trigger) {
      const std::uint64_t cost = make_putter(parent.node, false, 0);
      if (cost < best) {
        best = cost;
        all_triggers = true;
      }
    }
    if (best >= kImpossible) return kImpossible;
    total += best;
    if (!apply) continue;
    if (all_triggers) make_putter(parent.node, true, 0);
    else if (sibling != kNoRow) make_putter(sibling, true, 0);
    else protect(parent.node, true, depth + 1);
  }
  return std::min(total, kImpossible);
}

bool TrapFinder::grow(u32 start) {
  clear();
  put(start);
  for (std::size_t head = 0; head < set_.size(); ++head) {
    if (set_.size() > kMaxGrown) return false;
    const u32 mode = set_[head];
    const u32 atom = net_.atom_of_mode[mode];
    const u32 base = net_.mode_base[atom];
    for (const PortMove& move : net_.moves_out(mode)) {
      const u32 to = base + move.other;
      const u32 port = net_.port_base[atom] + move.port;
      if (in_set_[to] != 0 || !is_possible(port, mode) || !is_in_bad_context(port, 0)) continue;
      const std::uint64_t here = in_large_[to] != 0 ? 1 + net_.moves_out(to).size() : kImpossible;
      const std::uint64_t there = protect(port, false, 0);
      if (here >= kImpossible && there >= kImpossible) return false;
      if (there < here) protect(port, true, 0);
      else put(to);
    }
  }
  return true;
}

// Drops one mode and what cannot stay without it; keeps everything if the start would go too.
bool TrapFinder::shrink(u32 start, std::size_t drop) {
  std::vector<u32> gone{set_[drop]};
  in_set_[set_[drop]] = 0;
  bool fails = false;
  for (bool changed = true; changed && !fails;) {
    changed = false;
    for (u32 mode : set_) {
      if (in_set_[mode] == 0 || !leaves_set(mode)) continue;
      if (mode == start) {
        fails = true;
        break;
      }
      in_set_[mode] = 0;
      gone.push_back(mode);
      changed = true;
    }
  }
  if (!fails) return true;
  for (u32 mode : gone) in_set_[mode] = 1;
  return false;
}

std::vector<TokenInvariant> TrapFinder::find(const std::vector<std::uint8_t>& marked) {
  ModeReachability outside(net_, Direction::Backward, &reachable_);
  for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
    if (marked[mode] != 0 || !reachable_.is_on(mode)) outside.turn_on(mode);
  }
  outside.run();
  for (u32 mode = 0; mode < net_.mode_count(); ++mode) in_large_[mode] = outside.is_on(mode) ? 0 : 1;

  std::vector<TokenInvariant> found;
  std::vector<std::uint8_t> is_covered(net_.mode_count(), 0);
  for (u32 atom = 0; atom + 1 < net_.mode_base.size() && found.size() < kBatch; ++atom) {
    const std::vector<u32>& initial = net_.class_at(atom).initial;
    const u32 base = net_.mode_base[atom];
    const bool is_inside = !initial.empty() && std::all_of(initial.begin(), initial.end(),
                                                           [&](u32 mode) { return in_large_[base + mode] != 0; });
    if (!is_inside || is_covered[base + initial[0]] != 0) continue;
    TokenInvariant trap;
    const u32 start = base + initial[0];
    // With several initial modes only the largest trap is sure to hold them all.
    bool is_small = initial.size() == 1 && grow(start);
    if (is_small && set_.size() <= kMaxShrunk) {
      for (std::size_t k = set_.size(); k-- > 1;) {
        if (in_set_[set_[k]] != 0) shrink(start, k);
      }
      std::vector<u32> kept;
      for (u32 mode : set_) {
        if (in_set_[mode] != 0) kept.push_back(mode);
      }
      set_ = std::move(kept);
    }
    is_small = is_small && is_trap();
    if (is_small) {
      trap.modes = set_;
    } else {
      for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
        if (in_large_[mode] != 0) trap.modes.push_back(mode);
      }
    }
    clear();
    std::sort(trap.modes.begin(), trap.modes.end());
    for (u32 mode : trap.modes) is_covered[mode] = 1;
    if (is_small && is_state_machine_component(trap.modes)) trap.kind = InvariantKind::OneToken;
    found.push_back(std::move(trap));
    if (!is_small) break;
  }
  return found;
}

}  // namespace bip::verify
