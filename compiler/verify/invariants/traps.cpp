// See traps.hpp. A port "may put nothing" if one of its possible moves ends outside of the set; a step leaves the set
// if each of its ports may put nothing and one of them moves out of the set.
#include "compiler/verify/invariants/traps.hpp"

#include <algorithm>

#include "compiler/base/log.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

TrapFinder::TrapFinder(const Net& net, const ModeReachability& reachable)
    : net_(net),
      reachable_(reachable),
      place_invariants_(net, reachable),
      in_largest_(net.mode_count(), 0),
      in_set_(net.mode_count(), 0) {}

void TrapFinder::insert(u32 mode) {
  if (in_set_[mode] != 0) return;
  in_set_[mode] = 1;
  set_.push_back(mode);
}
void TrapFinder::clear() {
  for (u32 mode : set_) in_set_[mode] = 0;
  set_.clear();
}

// Is there a choice below the node that puts no token into the set? Beyond kMaxDepth the answer is yes: fewer sets
// count as traps, and those that do are traps.
bool TrapFinder::may_put_nothing(u32 node, u32 depth) const {
  if (depth > kMaxDepth) return true;
  const auto below = [&](const Edge& child) { return may_put_nothing(child.node, depth + 1); };
  const std::span<const Edge> children = net_.graph.children(node);
  switch (net_.graph.nodes[node].kind) {
    case ConnectorNodeKind::Port: {
      const u32 base = net_.mode_base[net_.graph.atom_of_port[node]];
      for (const Move& move : net_.moves(node)) {
        if (in_set_[base + move.to] == 0 && is_possible(node, base + move.from)) return true;
      }
      return false;
    }
    case ConnectorNodeKind::All: return std::all_of(children.begin(), children.end(), below);
    // A trigger may fire alone.
    case ConnectorNodeKind::Trigger:
      return std::any_of(children.begin(), children.end(),
                         [&](const Edge& child) { return child.is_trigger && below(child); });
    case ConnectorNodeKind::Any: return std::any_of(children.begin(), children.end(), below);
  }
  BIP_UNREACHABLE("kind of a node");
}

bool TrapFinder::siblings_may_put_nothing(u32 parent, const Edge& edge_up, u32 child) const {
  const std::span<const Edge> children = net_.graph.children(parent);
  switch (net_.graph.nodes[parent].kind) {
    case ConnectorNodeKind::All:
      return std::all_of(children.begin(), children.end(),
                         [&](const Edge& other) { return other.node == child || may_put_nothing(other.node, 0); });
    case ConnectorNodeKind::Trigger:
      return edge_up.is_trigger || std::any_of(children.begin(), children.end(), [&](const Edge& other) {
               return other.is_trigger && other.node != child && may_put_nothing(other.node, 0);
             });
    case ConnectorNodeKind::Port:
    case ConnectorNodeKind::Any: return true;
  }
  BIP_UNREACHABLE("kind of a node");
}

// Is there a step with this node in which every other port may put nothing?
bool TrapFinder::rest_of_step_may_put_nothing(u32 node, u32 depth) const {
  if (net_.graph.nodes[node].is_root || depth > kMaxDepth) return true;
  for (const Edge& parent : net_.graph.parents(node)) {
    if (siblings_may_put_nothing(parent.node, parent, node) && rest_of_step_may_put_nothing(parent.node, depth + 1))
      return true;
  }
  return false;
}

// Can a step take the token out of this mode and put none into the set?
bool TrapFinder::can_be_left(u32 mode) const {
  const u32 atom = net_.atom_of_mode[mode];
  const u32 base = net_.mode_base[atom];
  for (const PortMove& move : net_.moves_out(mode)) {
    const u32 port = net_.graph.port_base[atom] + move.port;
    if (in_set_[base + move.other] != 0 || !is_possible(port, mode)) continue;
    if (rest_of_step_may_put_nothing(port, 0)) return true;
  }
  return false;
}

bool TrapFinder::is_trap() const {
  return std::none_of(set_.begin(), set_.end(), [&](u32 mode) { return can_be_left(mode); });
}

// Whatever the initial mode of some atom of the set is, it lies in the set.
bool TrapFinder::is_marked_initially() const {
  return std::any_of(set_.begin(), set_.end(), [&](u32 member) {
    const u32 atom = net_.atom_of_mode[member];
    const std::vector<u32>& initial = net_.class_at(atom).initial;
    return !initial.empty() && std::all_of(initial.begin(), initial.end(),
                                           [&](u32 mode) { return in_set_[net_.mode_base[atom] + mode] != 0; });
  });
}

bool TrapFinder::holds(const std::vector<u32>& modes) {
  BIP_ASSERT(set_.empty(), "a set of {} modes is in work", set_.size());
  for (u32 mode : modes) insert(mode);
  const bool result = is_trap() && is_marked_initially();
  clear();
  return result;
}

// Estimates how many modes (weighted by the ways out of them) have to join the set so that every choice below the node
// puts a token into it; kImpossible if that leads out of the largest trap. With Apply they join.
std::uint64_t TrapFinder::make_node_put(u32 node, Repair repair, u32 depth) {
  if (depth > kMaxDepth) return kImpossible;
  const std::span<const Edge> children = net_.graph.children(node);
  const auto sum_over = [&](auto&& is_counted) {
    std::uint64_t cost = 0;
    for (const Edge& child : children) {
      if (is_counted(child)) cost += make_node_put(child.node, repair, depth + 1);
    }
    return std::min(cost, kImpossible);
  };
  switch (net_.graph.nodes[node].kind) {
    // All possible moves of the port must end in the set.
    case ConnectorNodeKind::Port: {
      const u32 base = net_.mode_base[net_.graph.atom_of_port[node]];
      std::uint64_t cost = 0;
      for (const Move& move : net_.moves(node)) {
        const u32 to = base + move.to;
        if (in_set_[to] != 0 || !is_possible(node, base + move.from)) continue;
        if (in_largest_[to] == 0) return kImpossible;
        cost += 1 + net_.moves_out(to).size();
        if (repair == Repair::Apply) insert(to);
      }
      return cost;
    }
    // One child is enough: the cheapest.
    case ConnectorNodeKind::All: {
      std::uint64_t best = kImpossible;
      u32 cheapest = kNoRow;
      for (const Edge& child : children) {
        const std::uint64_t cost = make_node_put(child.node, Repair::Estimate, depth + 1);
        if (cost < best) {
          best = cost;
          cheapest = child.node;
        }
      }
      if (repair == Repair::Apply && cheapest != kNoRow) make_node_put(cheapest, Repair::Apply, depth + 1);
      return best;
    }
    // Each trigger may fire alone, and each alternative too.
    case ConnectorNodeKind::Trigger: return sum_over([](const Edge& child) { return child.is_trigger; });
    case ConnectorNodeKind::Any: return sum_over([](const Edge&) { return true; });
  }
  BIP_UNREACHABLE("kind of a node");
}

// Estimates, or makes, that in every step with this node another port puts a token into the set.
std::uint64_t TrapFinder::make_rest_of_step_put(u32 node, Repair repair, u32 depth) {
  if (net_.graph.nodes[node].is_root || depth > kMaxDepth) return kImpossible;
  std::uint64_t total = 0;
  for (const Edge& parent : net_.graph.parents(node)) {
    if (!siblings_may_put_nothing(parent.node, parent, node) || !rest_of_step_may_put_nothing(parent.node, depth + 1))
      continue;
    // Three ways, the cheapest counts: further up, one sibling of a rendezvous, all triggers of a group.
    const ConnectorNodeKind kind = net_.graph.nodes[parent.node].kind;
    std::uint64_t best = make_rest_of_step_put(parent.node, Repair::Estimate, depth + 1);
    u32 sibling = kNoRow;
    bool all_triggers = false;
    if (kind == ConnectorNodeKind::All) {
      for (const Edge& other : net_.graph.children(parent.node)) {
        if (other.node == node) continue;
        const std::uint64_t cost = make_node_put(other.node, Repair::Estimate, 0);
        if (cost < best) {
          best = cost;
          sibling = other.node;
        }
      }
    } else if (kind == ConnectorNodeKind::Trigger && !parent.is_trigger) {
      const std::uint64_t cost = make_node_put(parent.node, Repair::Estimate, 0);
      if (cost < best) {
        best = cost;
        all_triggers = true;
      }
    }
    if (best >= kImpossible) return kImpossible;
    total += best;
    if (repair == Repair::Estimate) continue;
    if (all_triggers) make_node_put(parent.node, Repair::Apply, 0);
    else if (sibling != kNoRow) make_node_put(sibling, Repair::Apply, 0);
    else make_rest_of_step_put(parent.node, Repair::Apply, depth + 1);
  }
  return std::min(total, kImpossible);
}

// Grows a trap around `start` within the largest one: each step that would leave the set is repaired by the cheaper of
// two ways, its target joins or another port of the step puts a token into the set. False: too large, or no repair.
bool TrapFinder::grow(u32 start) {
  clear();
  insert(start);
  for (std::size_t head = 0; head < set_.size(); ++head) {
    if (set_.size() > kMaxGrown) return false;
    const u32 mode = set_[head];
    const u32 atom = net_.atom_of_mode[mode];
    const u32 base = net_.mode_base[atom];
    for (const PortMove& move : net_.moves_out(mode)) {
      const u32 to = base + move.other;
      const u32 port = net_.graph.port_base[atom] + move.port;
      if (in_set_[to] != 0 || !is_possible(port, mode) || !rest_of_step_may_put_nothing(port, 0)) continue;
      const std::uint64_t target_joins = in_largest_[to] != 0 ? 1 + net_.moves_out(to).size() : kImpossible;
      const std::uint64_t others_put = make_rest_of_step_put(port, Repair::Estimate, 0);
      if (target_joins >= kImpossible && others_put >= kImpossible) return false;
      if (others_put < target_joins) make_rest_of_step_put(port, Repair::Apply, 0);
      else insert(to);
    }
  }
  BIP_ASSERT(std::all_of(set_.begin(), set_.end(), [&](u32 mode) { return in_largest_[mode] != 0; }),
             "a trap of {} modes leaves the largest one", set_.size());
  return true;
}

// Drops one mode and every mode that cannot stay without it; restores all if `start` would have to go.
bool TrapFinder::shrink(u32 start, std::size_t drop) {
  std::vector<u32> dropped{set_[drop]};
  in_set_[set_[drop]] = 0;
  bool fails = false;
  for (bool changed = true; changed && !fails;) {
    changed = false;
    for (u32 mode : set_) {
      if (in_set_[mode] == 0 || !can_be_left(mode)) continue;
      if (mode == start) {
        fails = true;
        break;
      }
      in_set_[mode] = 0;
      dropped.push_back(mode);
      changed = true;
    }
  }
  if (!fails) return true;
  for (u32 mode : dropped) in_set_[mode] = 1;
  return false;
}

void TrapFinder::shrink_all(u32 start) {
  for (std::size_t k = set_.size(); k-- > 1;) {
    if (in_set_[set_[k]] != 0) shrink(start, k);
  }
  std::erase_if(set_, [&](u32 mode) { return in_set_[mode] == 0; });
}

// The complement of the backward fixpoint from the marked and the unreachable modes.
void TrapFinder::compute_largest_trap(const std::vector<std::uint8_t>& marked) {
  ModeReachability complement(net_, Direction::Backward, &reachable_);
  for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
    if (marked[mode] != 0 || !reachable_.is_on(mode)) complement.turn_on(mode);
  }
  complement.run();
  for (u32 mode = 0; mode < net_.mode_count(); ++mode) in_largest_[mode] = complement.is_on(mode) ? 0 : 1;
}

std::vector<TokenInvariant> TrapFinder::find(const std::vector<std::uint8_t>& marked) {
  BIP_ASSERT(marked.size() == net_.mode_count(), "{} marks of {} modes", marked.size(), net_.mode_count());
  compute_largest_trap(marked);
  std::vector<TokenInvariant> found;
  std::vector<std::uint8_t> is_covered(net_.mode_count(), 0);
  for (u32 atom = 0; atom + 1 < net_.mode_base.size() && found.size() < kMaxTrapsPerCall; ++atom) {
    // Around each initial mode in the largest trap that no trap of this call contains yet.
    const std::vector<u32>& initial = net_.class_at(atom).initial;
    const u32 base = net_.mode_base[atom];
    const bool is_inside = !initial.empty() && std::all_of(initial.begin(), initial.end(),
                                                           [&](u32 mode) { return in_largest_[base + mode] != 0; });
    if (!is_inside || is_covered[base + initial[0]] != 0) continue;
    TokenInvariant trap;
    const u32 start = base + initial[0];
    // Of several initial modes of one atom only the largest trap is sure to contain all.
    bool is_small = initial.size() == 1 && grow(start);
    if (is_small && set_.size() <= kMaxShrunk) shrink_all(start);
    is_small = is_small && is_trap();
    if (is_small) {
      trap.modes = set_;
    } else {
      for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
        if (in_largest_[mode] != 0) trap.modes.push_back(mode);
      }
    }
    clear();
    std::sort(trap.modes.begin(), trap.modes.end());
    for (u32 mode : trap.modes) is_covered[mode] = 1;
    BIP_ASSERT(holds(trap.modes), "{} modes are no marked trap", trap.modes.size());
    BIP_ASSERT(!is_satisfied(trap, marked), "a trap of {} modes is marked in the candidate", trap.modes.size());
    if (is_small && place_invariants_.is_state_machine_component(trap.modes)) trap.kind = InvariantKind::OneToken;
    BIP_LOG(Traps, 2, "{} of {} modes around {}", is_small ? "trap" : "largest trap", trap.modes.size(),
            net_.mode_name(start));
    found.push_back(std::move(trap));
    // The largest trap covers all the others.
    if (!is_small) break;
  }
  BIP_LOG(Traps, 1, "{} traps exclude the candidate", found.size());
  return found;
}

}  // namespace bip::verify
