// The tree of a connector, bound connectors in place of the parameters that name them, and the configurations that it
// has.
#include <algorithm>

#include "compiler/verify/net/abstract_code.hpp"
#include "compiler/verify/symbolic/transition_system_builder.hpp"

namespace bip::verify {

u32 TransitionSystemBuilder::add_binding(Tree& tree, const PortRef& ref, u32 use, bool is_trigger, u32 depth) {
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

// The values of a merged port are those of the alternative taken: where code may see them, configurations one by one
// say which it is.
u32 TransitionSystemBuilder::bind_param(Tree& tree, const Connector& connector, u32 param, u32 use, bool is_trigger,
                                        u32 depth) {
  const u32 node = add_binding(tree, connector.ports[param], use, is_trigger, depth);
  tree.uses[use].param_nodes[param] = node;
  const ConnectorType& type = system_.connector_types[connector.type];
  const bool has_values = !system_.port_types[type.params[param].type].variables.empty();
  const bool has_code = std::any_of(type.clauses.begin(), type.clauses.end(), [](const Clause& clause) {
    return clause.guard.is_valid() || clause.up.is_valid() || clause.down.is_valid();
  });
  if (tree.nodes[node].kind == Kind::Choice && has_values && has_code) tree.is_plain = false;
  return node;
}

// Can any choice of alternatives be taken together, and is none of them a part of another one? So if no port has two
// leaves, and two leaves of one atom are alternatives to each other.
bool TransitionSystemBuilder::has_free_choices(const Tree& tree) const {
  std::vector<u32> parent(tree.nodes.size(), kNoRow);
  std::map<u32, Leaves> of_atom;
  for (u32 row = 0; row < tree.nodes.size(); ++row) {
    for (u32 child : tree.nodes[row].children) parent[child] = row;
    if (tree.nodes[row].kind == Kind::Leaf) of_atom[tables_.port_atom[tree.nodes[row].port]].push_back(row);
  }
  const auto meet = [&](u32 a, u32 b) {
    std::vector<u32> above;
    for (; a != kNoRow; a = parent[a]) above.push_back(a);
    while (std::find(above.begin(), above.end(), b) == above.end()) b = parent[b];
    return b;
  };
  for (const auto& [atom, leaves] : of_atom) {
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      for (std::size_t j = i + 1; j < leaves.size(); ++j) {
        if (tree.nodes[leaves[i]].port == tree.nodes[leaves[j]].port) return false;
        if (tree.nodes[meet(leaves[i], leaves[j])].kind != Kind::Choice) return false;
      }
    }
  }
  return true;
}

u32 TransitionSystemBuilder::add_use(Tree& tree, u32 connector, u32 depth) {
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
      const u32 child = bind_param(tree, row, define.param, use, false, depth);
      tree.nodes[made[k]].children.push_back(child);
      continue;
    }
    for (u32 child_row : define.children) {
      const DefineNode& child = type.define[child_row];
      u32 node = kNoRow;
      if (child.is_leaf) {
        node = bind_param(tree, row, child.param, use, child.trigger, depth);
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
bool TransitionSystemBuilder::configurations(const Tree& tree, u32 row, std::vector<Leaves>& out) const {
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
std::vector<Signal> TransitionSystemBuilder::fixed_choice(const Tree& tree, const Leaves& leaves) const {
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

// Of the rows, one that is available, if `when`: an input a row but the last says whether it is this one.
void TransitionSystemBuilder::choose_one(const std::vector<u32>& rows, const std::vector<Signal>& available,
                                         Signal when, std::vector<Signal>& chosen) {
  std::vector<Signal> later(rows.size() + 1, kFalse);
  for (std::size_t k = rows.size(); k-- > 0;) later[k] = aig_.make_or(later[k + 1], available[rows[k]]);
  Signal rest = when;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Signal wanted = later[k + 1] == kFalse ? kTrue : aig_.make_or(aig_.make_input(), negated(later[k + 1]));
    chosen[rows[k]] = aig_.make_and(aig_.make_and(rest, available[rows[k]]), wanted);
    rest = aig_.make_and(rest, negated(chosen[rows[k]]));
  }
}

// Everybody that is available, from the root down; of alternatives, any one that is.
std::vector<Signal> TransitionSystemBuilder::largest_choice(const Tree& tree) {
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
      here = transition_system_.port_is_on[node.port];
      continue;
    }
    const bool needs_one = node.has_trigger || node.kind == Kind::Choice;
    here = needs_one ? kFalse : kTrue;
    for (u32 child : node.children) {
      if (node.kind == Kind::Choice) here = aig_.make_or(here, available[child]);
      else if (!node.has_trigger) here = aig_.make_and(here, available[child]);
      else if (tree.nodes[child].is_trigger) here = aig_.make_or(here, available[child]);
    }
  }
  chosen[order[0]] = available[order[0]];
  for (u32 row : order) {
    if (tree.nodes[row].kind == Kind::Choice) {
      choose_one(tree.nodes[row].children, available, chosen[row], chosen);
      continue;
    }
    for (u32 child : tree.nodes[row].children) {
      chosen[child] = tree.nodes[row].has_trigger ? aig_.make_and(chosen[row], available[child]) : chosen[row];
    }
  }
  return chosen;
}

}  // namespace bip::verify
