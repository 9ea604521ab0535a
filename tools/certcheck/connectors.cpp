// Connectors with those that they bind in place of their parameters, and the configurations that they have.
#include <algorithm>

#include "tools/certcheck/symbolic.hpp"

namespace certcheck {

namespace {
constexpr std::size_t kMaxConfigurations = 512;
constexpr int kMaxDepth = 400;
bool is(const z3::expr& e, bool value) { return value ? e.is_true() : e.is_false(); }
// Divisions and calls.
bool may_fault(const Tree* body) {
  std::vector<const Tree*> todo;
  if (body != nullptr) todo.push_back(body);
  while (!todo.empty()) {
    const Tree& e = *todo.back();
    todo.pop_back();
    if (e.head() == "div" || e.head() == "mod" || e.head() == "call") return true;
    for (const Tree& item : e.items) todo.push_back(&item);
  }
  return false;
}
}  // namespace

std::size_t Symbolic::add_binding(Expanded& tree, std::size_t use, const Tree& b, bool is_trigger, int depth) {
  if (depth > kMaxDepth) throw NotCheckable("connectors are nested too deeply");
  const std::size_t row = tree.parts.size();
  tree.parts.emplace_back();
  tree.parts[row].is_trigger = is_trigger;
  tree.parts[row].use = use;
  if (b.head() == "atom") {
    tree.parts[row].port = m_.first_port.at(b.items.at(1).row()) + b.items.at(2).row();
  } else if (b.head() == "choice") {
    tree.parts[row].kind = Kind::Any;
    tree.is_plain = false;
    const Tree* ports = m_.choices.at(b.items.at(1).row())->find("ports");
    for (std::size_t k = 1; ports != nullptr && k < ports->items.size(); ++k) {
      const std::size_t child = add_binding(tree, use, ports->items[k], false, depth + 1);
      tree.parts[row].children.push_back(child);
    }
  } else {
    tree.parts[row].is_link = true;
    tree.parts[row].kind = Kind::All;
    tree.parts[row].maximal = b.head() == "maximal";
    const std::size_t inner = add_use(tree, b.items.at(1).row(), depth + 1);
    tree.parts[row].use = inner;
    tree.parts[row].children.push_back(tree.uses[inner].root);
  }
  return row;
}

std::size_t Symbolic::add_group(Expanded& tree, std::size_t use, const Tree& group, int depth) {
  const std::size_t row = tree.parts.size();
  tree.parts.emplace_back();
  tree.parts[row].kind = Kind::All;
  tree.parts[row].use = use;
  tree.parts[row].is_trigger = group.head() == "trigger";
  const Tree& ports = *m_.connectors.at(tree.uses[use].connector).ports;
  for (std::size_t k = 1; k < group.items.size(); ++k) {
    const Tree& item = group.items[k];
    // (synchron PARAM) as the whole define: the group's one item is the word.
    const bool is_leaf = !item.is_list || !item.items.at(1).is_list;
    const std::size_t param = !is_leaf ? 0 : item.is_list ? item.items[1].row() : item.row();
    const bool trigger = item.is_list && item.head() == "trigger";
    const std::size_t child = is_leaf ? add_binding(tree, use, ports.items.at(1 + param), trigger, depth + 1) : add_group(tree, use, item, depth + 1);
    if (is_leaf) tree.uses[use].params.at(param) = child;
    tree.parts[row].children.push_back(child);
    tree.parts[row].has_trigger = tree.parts[row].has_trigger || trigger;
  }
  return row;
}

std::size_t Symbolic::add_use(Expanded& tree, std::size_t connector, int depth) {
  const Connector& c = m_.connectors.at(connector);
  const Tree& type = *m_.connector_types[c.type];
  const std::size_t use = tree.uses.size();
  tree.uses.push_back({connector, 0, std::vector<std::size_t>(c.ports->items.size() - 1, 0)});
  for (const Tree& item : type.items) {
    const bool guarded = item.head() == "clause" && item.find("guard") != nullptr && !(m_.evaluate(item.find("guard")->items.at(1), {}, {}) == Value{true, 1});
    if (guarded || (item.head() == "clause" && may_fault(item.find("up")))) tree.is_plain = false;
  }
  const std::size_t root = add_group(tree, use, type.find("define")->items.at(1), depth);
  tree.uses[use].root = root;
  return use;
}

bool Symbolic::list(const Expanded& tree, std::size_t row, std::vector<Leaves>& out) const {
  const Part& part = tree.parts[row];
  if (part.kind == Kind::Port) {
    out.push_back({row});
    return true;
  }
  if (part.kind == Kind::Any || part.is_link) {
    for (std::size_t child : part.children) {
      if (!list(tree, child, out)) return false;
    }
    return out.size() <= kMaxConfigurations;
  }
  std::vector<std::pair<Leaves, bool>> found{{{}, !part.has_trigger}};
  for (std::size_t child : part.children) {
    std::vector<Leaves> inner;
    if (!list(tree, child, inner)) return false;
    std::vector<std::pair<Leaves, bool>> next;
    if (part.has_trigger) next = found;
    for (const auto& [leaves, good] : found) {
      for (const Leaves& more : inner) {
        next.emplace_back(leaves, good || tree.parts[child].is_trigger);
        next.back().first.insert(more.begin(), more.end());
      }
    }
    if (next.size() > 2 * kMaxConfigurations) return false;
    found = std::move(next);
  }
  for (const auto& [leaves, good] : found) {
    if (good && !leaves.empty()) out.push_back(leaves);
  }
  return out.size() <= kMaxConfigurations;
}

std::vector<z3::expr> Symbolic::fixed(const Expanded& tree, const Leaves& leaves) {
  std::vector<z3::expr> chosen(tree.parts.size(), truth(false));
  // A child has a greater row than its parent.
  for (std::size_t row = tree.parts.size(); row-- > 0;) {
    bool is_chosen = leaves.contains(row);
    for (std::size_t child : tree.parts[row].children) is_chosen = is_chosen || is(chosen[child], true);
    if (is_chosen) chosen[row] = truth(true);
  }
  return chosen;
}

std::vector<z3::expr> Symbolic::largest(const Expanded& tree) {
  std::vector<z3::expr> available(tree.parts.size(), truth(false));
  for (std::size_t row = tree.parts.size(); row-- > 0;) {
    const Part& part = tree.parts[row];
    if (part.kind == Kind::Port) {
      available[row] = on_[part.port];
      continue;
    }
    z3::expr_vector needed(z_);
    for (std::size_t child : part.children) {
      if (!part.has_trigger || tree.parts[child].is_trigger) needed.push_back(available[child]);
    }
    available[row] = (part.has_trigger ? z3::mk_or(needed) : z3::mk_and(needed)).simplify();
  }
  std::vector<z3::expr> chosen(tree.parts.size(), truth(false));
  const std::size_t root = tree.uses[0].root;
  chosen[root] = available[root];
  for (std::size_t row = root; row < tree.parts.size(); ++row) {
    for (std::size_t child : tree.parts[row].children) {
      chosen[child] = tree.parts[row].has_trigger ? (chosen[row] && available[child]).simplify() : chosen[row];
    }
  }
  return chosen;
}

bool Symbolic::below(const Expanded& tree, std::size_t root, std::size_t row) const {
  if (root == row) return true;
  return std::any_of(tree.parts[root].children.begin(), tree.parts[root].children.end(), [&](std::size_t child) { return below(tree, child, row); });
}

}  // namespace certcheck
