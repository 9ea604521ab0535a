// See interaction_tree.hpp. The tree is built with a stack of its own; nodes come in the order in which they are
// popped.
#include "compiler/analysis/interaction_tree.hpp"

#include <algorithm>
#include <string>

#include "compiler/system/system.hpp"

namespace bip::analysis {

namespace {

using Kind = InteractionTree::Kind;

class InteractionTreeBuilder {
 public:
  InteractionTreeBuilder(const System& system, const InteractionTreeLimits& limits)
      : system_(system), limits_(limits) {}

  Result<InteractionTree> build(ConnectorId connector) {
    todo_.push_back({.parent = kNoRow, .use = add_use(connector), .define = 0});
    while (!todo_.empty()) {
      const Task task = todo_.back();
      todo_.pop_back();
      if (task.depth > limits_.depth || tree_.nodes.size() > limits_.nodes)
        return Failure{"it is nested too deeply or too large"};
      if (task.ref == nullptr) add_group(task);
      else add_binding(task);
    }
    for (std::size_t row = tree_.nodes.size(); row-- > 0;) {
      InteractionTree::Node& node = tree_.nodes[row];
      node.end = node.children.empty() ? static_cast<u32>(row + 1) : tree_.nodes[node.children.back()].end;
      BIP_ASSERT(node.end > row && node.end <= tree_.nodes.size(), "node {} ends at {}", row, node.end);
    }
    return std::move(tree_);
  }

 private:
  // A node that is to be made: a group of a `define`, or what a parameter is bound to.
  struct Task {
    u32 parent = kNoRow;
    u32 use = 0;
    u32 define = 0;                // group
    const PortRef* ref = nullptr;  // binding
    u32 param = kNoRow;            // binding, unless it is an alternative of a merged port
    bool is_trigger = false;
    u32 depth = 0;
  };

  u32 add_use(ConnectorId connector) {
    const std::size_t params = system_.connectors[connector].ports.size();
    tree_.uses.push_back({connector, 0, std::vector<u32>(params, kNoRow)});
    return static_cast<u32>(tree_.uses.size() - 1);
  }
  u32 add_node(Kind kind, const Task& task) {
    const u32 row = static_cast<u32>(tree_.nodes.size());
    tree_.nodes.push_back({.kind = kind, .is_trigger = task.is_trigger, .use = task.use, .children = {}});
    if (task.parent != kNoRow) {
      tree_.nodes[task.parent].children.push_back(row);
      if (task.is_trigger) tree_.nodes[task.parent].has_trigger = true;
    }
    return row;
  }

  void add_group(const Task& task) {
    const u32 row = add_node(Kind::Group, task);
    if (task.define == 0) tree_.uses[task.use].root = row;
    const Connector& connector = system_.connectors[tree_.uses[task.use].connector];
    const ConnectorType& type = system_.connector_types[connector.type];
    const auto add_child = [&](u32 define, bool is_trigger) {
      const DefineNode& node = type.define[define];
      Task child{.parent = row, .use = task.use, .define = define, .is_trigger = is_trigger, .depth = task.depth};
      if (node.is_leaf) {
        child.ref = &connector.ports[node.param];
        child.param = node.param;
      }
      todo_.push_back(child);
    };
    const DefineNode& define = type.define[task.define];
    // A root that is a leaf counts as a group of one.
    if (define.is_leaf) add_child(task.define, false);
    for (std::size_t k = define.children.size(); k-- > 0;)
      add_child(define.children[k], type.define[define.children[k]].trigger);
  }

  void add_binding(const Task& task) {
    const PortRef& ref = *task.ref;
    u32 row = kNoRow;
    switch (ref.kind) {
      case PortRef::Kind::Atom:
        row = add_node(Kind::Leaf, task);
        tree_.nodes[row].atom = ref.atom;
        tree_.nodes[row].port = ref.port;
        break;
      case PortRef::Kind::Choice: {
        row = add_node(Kind::Choice, task);
        const std::vector<PortRef>& ports = system_.choices[ref.choice].ports;
        for (std::size_t k = ports.size(); k-- > 0;)
          todo_.push_back({.parent = row, .use = task.use, .ref = &ports[k], .depth = task.depth + 1});
        break;
      }
      case PortRef::Kind::Connector: {
        row = add_node(Kind::Link, task);
        const u32 below = add_use(ref.connector);
        tree_.nodes[row].maximal_only = ref.maximal_only;
        tree_.nodes[row].use = below;
        todo_.push_back({.parent = row, .use = below, .define = 0, .depth = task.depth + 1});
        break;
      }
    }
    if (task.param != kNoRow) tree_.uses[task.use].param_nodes[task.param] = row;
  }

  const System& system_;
  const InteractionTreeLimits limits_;
  InteractionTree tree_;
  std::vector<Task> todo_;  // the next node on top
};

}  // namespace

Result<InteractionTree> build_interaction_tree(const System& system, ConnectorId connector,
                                               const InteractionTreeLimits& limits) {
  return InteractionTreeBuilder(system, limits).build(connector);
}

InteractionEnumerator::InteractionEnumerator(const InteractionTree& tree, u32 node)
    : tree_(tree), root_(node), is_active_(tree.nodes.size(), 1), alternative_(tree.nodes.size(), 0) {
  BIP_ASSERT(node < tree.nodes.size(), "node {} of {}", node, tree.nodes.size());
}

bool InteractionEnumerator::next(Leaves& leaves) {
  const bool is_there = has_begun_ ? advance(root_) : first(root_);
  has_begun_ = true;
  if (!is_there || is_given_up()) return false;
  rejected_ = 0;
  leaves.clear();
  std::vector<u32> todo{root_};
  while (!todo.empty()) {
    const u32 row = todo.back();
    todo.pop_back();
    const InteractionTree::Node& node = tree_.nodes[row];
    if (node.kind == Kind::Leaf) {
      leaves.push_back(row);
    } else if (node.kind == Kind::Group) {
      for (std::size_t k = node.children.size(); k-- > 0;) {
        if (is_active_[node.children[k]] != 0) todo.push_back(node.children[k]);
      }
    } else {
      todo.push_back(node.children[alternative_[row]]);
    }
  }
  BIP_ASSERT(!leaves.empty() && std::is_sorted(leaves.begin(), leaves.end()), "interaction of node {}", root_);
  return true;
}

bool InteractionEnumerator::first(u32 row) {
  const InteractionTree::Node& node = tree_.nodes[row];
  if (node.kind == Kind::Leaf) return true;
  if (node.kind == Kind::Group) return first_of_group(row);
  for (u32 k = 0; k < node.children.size(); ++k) {
    alternative_[row] = k;
    if (first(node.children[k])) return true;
  }
  return false;
}

bool InteractionEnumerator::advance(u32 row) {
  const InteractionTree::Node& node = tree_.nodes[row];
  if (node.kind == Kind::Leaf) return false;
  if (node.kind == Kind::Group) return advance_group(row);
  if (advance(node.children[alternative_[row]])) return true;
  for (u32 k = alternative_[row] + 1; k < node.children.size(); ++k) {
    alternative_[row] = k;
    if (first(node.children[k])) return true;
  }
  return false;
}

bool InteractionEnumerator::first_of_group(u32 row) {
  const InteractionTree::Node& group = tree_.nodes[row];
  if (!group.has_trigger) {
    return !group.children.empty() &&
           std::all_of(group.children.begin(), group.children.end(), [this](u32 child) { return first(child); });
  }
  // The empty set comes first and is no interaction.
  for (u32 child : group.children) is_active_[child] = 0;
  return advance_group(row);
}

bool InteractionEnumerator::advance_group(u32 row) {
  const InteractionTree::Node& group = tree_.nodes[row];
  while (!is_given_up() && step_group(group)) {
    if (!group.has_trigger || has_active_trigger(group)) return true;
    ++rejected_;
  }
  return false;
}

bool InteractionEnumerator::has_active_trigger(const InteractionTree::Node& group) const {
  return std::any_of(group.children.begin(), group.children.end(),
                     [this](u32 child) { return is_active_[child] != 0 && tree_.nodes[child].is_trigger; });
}

// The combinations of the first k children are G(k) = G(k-1) without child k, then each of G(k-1) with each interaction
// of child k; of a rendezvous the second part only.
bool InteractionEnumerator::step_group(const InteractionTree::Node& group) {
  const std::vector<u32>& children = group.children;
  const std::size_t count = children.size();
  const auto restart_from = [&](std::size_t k) {
    for (; k < count; ++k) {
      if (is_active_[children[k]] != 0) (void)first(children[k]);
    }
  };
  std::size_t k = count;
  while (k > 0 && (is_active_[children[k - 1]] == 0 || !advance(children[k - 1]))) --k;
  if (k > 0) {
    restart_from(k);
    return true;
  }
  if (!group.has_trigger) return false;
  // All active children are at their last interaction: one more child takes part, those before it leave.
  while (k < count && (is_active_[children[k]] != 0 || !first(children[k]))) ++k;
  if (k == count) return false;
  for (std::size_t j = 0; j < k; ++j) is_active_[children[j]] = 0;
  is_active_[children[k]] = 1;
  restart_from(k + 1);
  return true;
}

Result<std::vector<Leaves>> list_interactions(const InteractionTree& tree, u32 node, std::size_t limit) {
  InteractionEnumerator enumerator(tree, node);
  std::vector<Leaves> all;
  Leaves leaves;
  while (enumerator.next(leaves)) {
    if (all.size() == limit) return Failure{"it has more than " + std::to_string(limit) + " interactions"};
    all.push_back(leaves);
  }
  if (enumerator.is_given_up()) return Failure{"it has more than " + std::to_string(limit) + " interactions"};
  return all;
}

std::vector<std::uint8_t> chosen_nodes(const InteractionTree& tree, const Leaves& leaves) {
  std::vector<std::uint8_t> chosen(tree.nodes.size(), 0);
  for (u32 leaf : leaves) {
    BIP_ASSERT(tree.nodes[leaf].kind == Kind::Leaf, "node {} is no leaf", leaf);
    chosen[leaf] = 1;
  }
  for (std::size_t row = tree.nodes.size(); row-- > 0;) {
    for (u32 child : tree.nodes[row].children) chosen[row] = chosen[row] != 0 || chosen[child] != 0 ? 1 : 0;
  }
  return chosen;
}

u32 chosen_alternative(const InteractionTree& tree, u32 node, const std::vector<std::uint8_t>& chosen) {
  if (node == kNoRow) return kNoRow;
  if (tree.nodes[node].kind != Kind::Choice) return node;
  for (u32 child : tree.nodes[node].children) {
    if (chosen[child] != 0) return child;
  }
  return kNoRow;
}

const Clause* chosen_clause(const System& system, const InteractionTree::Use& use,
                            const std::vector<std::uint8_t>& chosen) {
  std::vector<u32> params;
  for (u32 p = 0; p < use.param_nodes.size(); ++p) {
    if (use.param_nodes[p] != kNoRow && chosen[use.param_nodes[p]] != 0) params.push_back(p);
  }
  for (const Clause& clause : system.connector_types[system.connectors[use.connector].type].clauses) {
    if (clause.params == params) return &clause;
  }
  return nullptr;
}

}  // namespace bip::analysis
