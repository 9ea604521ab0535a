// The tree of a connector, bound connectors in place of the parameters that name them, and the configurations that it has.
#include <algorithm>

#include "compiler/verify/abstract_code.hpp"
#include "compiler/verify/machine_builder.hpp"

namespace bip::verify {

u32 MachineBuilder::add_binding(Tree& tree, const PortRef& ref, u32 use, bool is_trigger, u32 depth) {
  const u32 row = static_cast<u32>(tree.nodes.size());
  tree.is_too_large = tree.is_too_large || row > kMaxTree || depth > kMaxDepth;
  tree.nodes.push_back({});
  tree.nodes[row].is_trigger = is_trigger;
  tree.nodes[row].use = use;
  if (tree.is_too_large) return row;
  if (ref.kind == PortRef::Kind::Atom) {
    tree.nodes[row].kind = Kind::Leaf;
    tree.nodes[row].port = tables_.instance(ref.atom.value, ref.port);
  } else if (ref.kind == PortRef::Kind::Choice) {
    tree.nodes[row].kind = Kind::Choice;
    tree.is_plain = false;
    for (const PortRef& port : system_.choices[ref.choice].ports) {
      const u32 child = add_binding(tree, port, use, false, depth + 1);
      tree.nodes[row].children.push_back(child);
    }
  } else {
    tree.nodes[row].kind = Kind::Link;
    tree.nodes[row].maximal_only = ref.maximal_only;
    const u32 below = add_use(tree, ref.connector.value, depth + 1);
    tree.nodes[row].use = below;
    tree.nodes[row].children.push_back(tree.uses[below].root);
  }
  return row;
}

u32 MachineBuilder::add_use(Tree& tree, u32 connector, u32 depth) {
  const Connector& row = system_.connectors[ConnectorId(std::size_t{connector})];
  const ConnectorType& type = system_.connector_types[row.type];
  const u32 use = static_cast<u32>(tree.uses.size());
  tree.uses.push_back({connector, 0, std::vector<u32>(type.params.size(), kNoRow)});
  for (std::size_t k = 0; k < type.clauses.size(); ++k) {
    const bool may_fault = image_.connector_types[image_.connectors[connector].type].clauses[k].may_fault;
    if (may_fault || !is_always_true(system_.code, type.clauses[k].guard)) tree.is_plain = false;
  }
  std::vector<u32> made(type.define.size(), kNoRow);
  // Rows of `define` are greater than their parent's.
  for (u32 k = 0; k < type.define.size(); ++k) {
    const DefineNode& define = type.define[k];
    if (define.is_leaf && k != 0) continue;
    made[k] = made[k] == kNoRow ? static_cast<u32>(tree.nodes.size()) : made[k];
    if (made[k] == tree.nodes.size()) {
      tree.nodes.push_back({});
      tree.nodes.back().use = use;
    }
    if (k == 0) tree.uses[use].root = made[0];
    if (define.is_leaf) {
      // A root that is a leaf counts as a group of one.
      const u32 child = add_binding(tree, row.ports[define.param], use, false, depth);
      tree.nodes[made[k]].children.push_back(child);
      tree.uses[use].param_nodes[define.param] = child;
      continue;
    }
    for (u32 child_row : define.children) {
      const DefineNode& child = type.define[child_row];
      u32 node = kNoRow;
      if (child.is_leaf) {
        node = add_binding(tree, row.ports[child.param], use, child.trigger, depth);
        tree.uses[use].param_nodes[child.param] = node;
      } else {
        node = static_cast<u32>(tree.nodes.size());
        tree.nodes.push_back({});
        tree.nodes[node].use = use;
        tree.nodes[node].is_trigger = child.trigger;
        made[child_row] = node;
      }
      tree.nodes[made[k]].children.push_back(node);
      tree.nodes[made[k]].has_trigger = tree.nodes[made[k]].has_trigger || child.trigger;
    }
  }
  return use;
}

// All configurations of the node, each as its leaves; false: too many.
bool MachineBuilder::configurations(const Tree& tree, u32 row, std::vector<Leaves>& out) const {
  const Node& node = tree.nodes[row];
  if (node.kind == Kind::Leaf) {
    out.push_back({row});
    return true;
  }
  if (node.kind != Kind::Group) {
    for (u32 child : node.children) {
      if (!configurations(tree, child, out)) return false;
    }
    return out.size() <= kMaxConfigurations;
  }
  std::vector<std::pair<Leaves, bool>> found{{{}, false}};
  for (u32 child : node.children) {
    std::vector<Leaves> below;
    if (!configurations(tree, child, below)) return false;
    std::vector<std::pair<Leaves, bool>> next;
    if (node.has_trigger) next = found;
    for (const auto& [leaves, triggered] : found) {
      for (const Leaves& more : below) {
        next.emplace_back(leaves, triggered || tree.nodes[child].is_trigger);
        next.back().first.insert(next.back().first.end(), more.begin(), more.end());
      }
    }
    if (next.size() > 2 * kMaxConfigurations) return false;
    found = std::move(next);
  }
  for (auto& [leaves, triggered] : found) {
    if (node.has_trigger && !triggered) continue;
    if (leaves.empty()) continue;
    std::sort(leaves.begin(), leaves.end());
    out.push_back(std::move(leaves));
  }
  return out.size() <= kMaxConfigurations;
}

// By node: is it chosen?
std::vector<Signal> MachineBuilder::fixed_choice(const Tree& tree, const Leaves& leaves) const {
  std::vector<Signal> chosen(tree.nodes.size(), kFalse);
  for (u32 leaf : leaves) chosen[leaf] = kTrue;
  // Whoever has a chosen child is chosen; groups of a define may come before or after others, so to the fixpoint.
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t n = tree.nodes.size(); n-- > 0;) {
      if (chosen[n] == kTrue) continue;
      for (u32 child : tree.nodes[n].children) {
        if (chosen[child] != kTrue) continue;
        chosen[n] = kTrue;
        changed = true;
      }
    }
  }
  return chosen;
}

// Everybody that is available, from the root down.
std::vector<Signal> MachineBuilder::largest_choice(const Tree& tree) {
  const std::size_t count = tree.nodes.size();
  std::vector<Signal> available(count, kFalse), chosen(count, kFalse);
  std::vector<u32> order{tree.uses[0].root};
  for (std::size_t head = 0; head < order.size(); ++head) {
    for (u32 child : tree.nodes[order[head]].children) order.push_back(child);
  }
  for (std::size_t k = order.size(); k-- > 0;) {
    const Node& node = tree.nodes[order[k]];
    Signal& here = available[order[k]];
    if (node.kind == Kind::Leaf) {
      here = m_.port_is_on[node.port];
      continue;
    }
    here = node.has_trigger ? kFalse : kTrue;
    for (u32 child : node.children) {
      if (!node.has_trigger) here = c_.both(here, available[child]);
      else if (tree.nodes[child].is_trigger) here = c_.either(here, available[child]);
    }
  }
  chosen[order[0]] = available[order[0]];
  for (u32 row : order) {
    for (u32 child : tree.nodes[row].children) {
      chosen[child] = tree.nodes[row].has_trigger ? c_.both(chosen[row], available[child]) : chosen[row];
    }
  }
  return chosen;
}

}  // namespace bip::verify
