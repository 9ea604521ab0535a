// See connector_tree.hpp. Recursion is bounded by kMaxDepth.
#include "compiler/exchange/connector_tree.hpp"

#include <algorithm>
#include <string_view>

namespace bip::exchange {

namespace {

constexpr u32 kMaxDepth = 200;
constexpr std::size_t kMaxNodes = 20000;
using Kind = ConnectorTree::Kind;

class Expander {
 public:
  explicit Expander(const System& system) : system_(system) {}
  Result<ConnectorTree> run(ConnectorId connector) {
    (void)add_use(connector, 0);
    if (is_too_large_) return Failure{"it is nested too deeply or too large"};
    return std::move(tree_);
  }

 private:
  u32 add_node(Kind kind, u32 use, bool is_trigger) {
    tree_.nodes.push_back({});
    tree_.nodes.back().kind = kind;
    tree_.nodes.back().use = use;
    tree_.nodes.back().is_trigger = is_trigger;
    return static_cast<u32>(tree_.nodes.size() - 1);
  }
  void add_child(u32 parent, u32 child) { tree_.nodes[parent].children.push_back(child); }

  u32 add_binding(const PortRef& ref, u32 use, bool is_trigger, u32 depth) {
    is_too_large_ = is_too_large_ || depth > kMaxDepth || tree_.nodes.size() > kMaxNodes;
    if (ref.kind == PortRef::Kind::Atom || is_too_large_) {
      const u32 row = add_node(Kind::Leaf, use, is_trigger);
      tree_.nodes[row].atom = ref.atom;
      tree_.nodes[row].port = ref.port;
      return row;
    }
    if (ref.kind == PortRef::Kind::Choice) {
      const u32 row = add_node(Kind::Choice, use, is_trigger);
      for (const PortRef& port : system_.choices[ref.choice].ports)
        add_child(row, add_binding(port, use, false, depth + 1));
      return row;
    }
    const u32 row = add_node(Kind::Link, use, is_trigger);
    tree_.nodes[row].maximal_only = ref.maximal_only;
    const u32 below = add_use(ref.connector, depth + 1);
    tree_.nodes[row].use = below;
    add_child(row, tree_.uses[below].root);
    return row;
  }

  u32 add_group(const Connector& row, u32 use, u32 define, bool is_trigger, u32 depth) {
    const u32 group = add_node(Kind::Group, use, is_trigger);
    is_too_large_ = is_too_large_ || depth > kMaxDepth || tree_.nodes.size() > kMaxNodes;
    if (is_too_large_) return group;
    const ConnectorType& type = system_.connector_types[row.type];
    const auto add_param = [&](u32 param, bool triggers) {
      const u32 child = add_binding(row.ports[param], use, triggers, depth + 1);
      tree_.uses[use].param_nodes[param] = child;
      add_child(group, child);
    };
    // A root that is a leaf counts as a group of one.
    if (type.define[define].is_leaf) add_param(type.define[define].param, false);
    for (u32 child : type.define[define].children) {
      const DefineNode& node = type.define[child];
      tree_.nodes[group].has_trigger = tree_.nodes[group].has_trigger || node.trigger;
      if (node.is_leaf) add_param(node.param, node.trigger);
      else add_child(group, add_group(row, use, child, node.trigger, depth + 1));
    }
    return group;
  }

  u32 add_use(ConnectorId connector, u32 depth) {
    const Connector& row = system_.connectors[connector];
    const u32 use = static_cast<u32>(tree_.uses.size());
    tree_.uses.push_back({connector, 0, std::vector<u32>(row.ports.size(), kNoRow)});
    const u32 root = add_group(row, use, 0, false, depth);
    tree_.uses[use].root = root;
    return use;
  }

  const System& system_;
  ConnectorTree tree_;
  bool is_too_large_ = false;
};

bool list(const ConnectorTree& tree, u32 row, std::vector<Leaves>& out) {
  const ConnectorTree::Node& node = tree.nodes[row];
  if (node.kind == Kind::Leaf) {
    out.push_back({row});
    return true;
  }
  if (node.kind != Kind::Group) {
    for (u32 child : node.children) {
      if (!list(tree, child, out)) return false;
    }
    return out.size() <= kMaxConfigurations;
  }
  std::vector<std::pair<Leaves, bool>> found{{{}, !node.has_trigger}};
  for (u32 child : node.children) {
    std::vector<Leaves> below;
    if (!list(tree, child, below)) return false;
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
    if (!triggered || leaves.empty()) continue;
    std::sort(leaves.begin(), leaves.end());
    out.push_back(std::move(leaves));
  }
  return out.size() <= kMaxConfigurations;
}

}  // namespace

std::string plain(const std::string& name) {
  std::string out = name;
  for (char& c : out) {
    const bool stays = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("_.[](), -").find(c) != std::string_view::npos;
    if (!stays) c = '_';
  }
  return out;
}

Result<ConnectorTree> expand(const System& system, ConnectorId connector) { return Expander(system).run(connector); }

Result<std::vector<Leaves>> configurations(const ConnectorTree& tree, u32 node) {
  std::vector<Leaves> all;
  if (!list(tree, node, all))
    return Failure{"it has more than " + std::to_string(kMaxConfigurations) + " interactions"};
  return all;
}

std::vector<std::uint8_t> chosen_nodes(const ConnectorTree& tree, const Leaves& leaves) {
  std::vector<std::uint8_t> chosen(tree.nodes.size(), 0);
  for (u32 leaf : leaves) chosen[leaf] = 1;
  for (std::size_t row = tree.nodes.size(); row-- > 0;) {
    for (u32 child : tree.nodes[row].children) chosen[row] = chosen[row] != 0 || chosen[child] != 0 ? 1 : 0;
  }
  return chosen;
}

u32 chosen_alternative(const ConnectorTree& tree, u32 node, const std::vector<std::uint8_t>& chosen) {
  if (node == kNoRow) return kNoRow;
  if (tree.nodes[node].kind != Kind::Choice) return node;
  for (u32 child : tree.nodes[node].children) {
    if (chosen[child] != 0) return child;
  }
  return kNoRow;
}

bool is_below(const ConnectorTree& tree, u32 root, u32 node) {
  std::vector<u32> todo{root};
  while (!todo.empty()) {
    const u32 row = todo.back();
    todo.pop_back();
    if (row == node) return true;
    todo.insert(todo.end(), tree.nodes[row].children.begin(), tree.nodes[row].children.end());
  }
  return false;
}

const Clause* chosen_clause(const System& system, const ConnectorTree::Use& use,
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

}  // namespace bip::exchange
