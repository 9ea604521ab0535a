// Connectors' trees: their configurations, who takes part in one, and whether guards and maximal progress allow it.
#include <algorithm>

#include "tools/certcheck/system.hpp"

namespace certcheck {

namespace {
constexpr std::size_t kMaxConfigurations = 512;
}  // namespace

const System::Shape& System::shape_of(std::size_t node, bool wants_list) {
  Shape& shape = shapes_[node];
  if (shape.tree.empty()) {
    Rows& tree = shape.tree = {node};
    for (std::size_t k = 0; k < tree.size(); ++k) {
      for (const Edge& edge : m_.nodes[tree[k]].children) tree.push_back(edge.node);
    }
    std::sort(tree.rbegin(), tree.rend());
    tree.erase(std::unique(tree.begin(), tree.end()), tree.end());
    shape.is_plain = is_plain(tree);
  }
  if (shape.is_listed || (shape.is_plain && !wants_list)) return shape;
  shape.is_listed = true;
  shape.is_complete = list(node, false, shape.all);
  if (!shape.is_complete) shape.all.clear();
  if (!shape.is_complete && !list(node, true, shape.all)) shape.all.clear();
  return shape;
}

// No guards, no errors, free choices at which no code looks. Free: any alternatives fit each other, for what two children of a node
// share, ports and with alternatives atoms, they share as alternatives.
bool System::is_plain(const Rows& tree) const {
  const auto is_any = [&](std::size_t row) { return m_.nodes[row].kind == Kind::Any; };
  const bool has_choice = std::any_of(tree.begin(), tree.end(), is_any);
  std::map<std::size_t, std::set<std::size_t>> below;
  for (auto row = tree.rbegin(); row != tree.rend(); ++row) {
    const Node& node = m_.nodes[*row];
    std::set<std::size_t>& mine = below[*row];
    if (node.kind == Kind::Port) mine.insert(has_choice ? m_.atom_of_port[*row] : *row);
    for (const Edge& edge : node.children) {
      for (std::size_t id : below[edge.node]) {
        if (!mine.insert(id).second && node.kind != Kind::Any) return false;
      }
    }
    if (node.connector == kNone) continue;
    const Connector& c = m_.connectors[node.connector];
    const bool chooses = std::any_of(c.params.begin(), c.params.end(), [&](const Edge& edge) { return is_any(edge.node); });
    for (const Clause& clause : m_.connector_types[c.type].clauses) {
      if ((!clause.guard->items.empty() && clause.guard->at(1).text != "true") || !clause.up->find({"div", "mod", "call"}).empty()) return false;
      if (chooses && clause.up->items.size() + clause.down->items.size() != 0) return false;
    }
  }
  return true;
}

// False: there are too many.
bool System::list(std::size_t row, bool only_smallest, std::vector<Parts>& out) const {
  const Node& node = m_.nodes[row];
  const bool is_one = node.kind == Kind::Any || (node.kind == Kind::Trigger && only_smallest);
  std::vector<std::pair<Parts, bool>> found{{{row}, node.kind == Kind::Port || node.kind == Kind::All}};
  for (const Edge& edge : node.children) {
    if (is_one && node.kind == Kind::Trigger && !edge.is_trigger) continue;
    std::vector<Parts> inner;
    if (!list(edge.node, only_smallest, inner)) return false;
    std::vector<std::pair<Parts, bool>> next;
    if (node.kind != Kind::All) next = found;
    for (const auto& [parts, is_good] : found) {
      if (is_one && parts.size() > 1) break;
      for (const Parts& more : inner) {
        next.emplace_back(parts, is_good || edge.is_trigger || is_one);
        next.back().first.insert(more.begin(), more.end());
        if (next.back().first.size() != parts.size() + more.size()) throw NotCheckable("a connector reaches a port in two ways");
      }
    }
    if (next.size() > 2 * kMaxConfigurations) return false;
    found = std::move(next);
  }
  for (auto& [parts, is_good] : found) {
    if (is_good) out.push_back(std::move(parts));
  }
  return out.size() <= kMaxConfigurations;
}

bool System::is_larger(const Parts& a, const Parts& b) { return a.size() > b.size() && std::includes(a.begin(), a.end(), b.begin(), b.end()); }

System::Chosen System::choice_of(const Rows& tree, const Parts& parts) const {
  Chosen chosen;
  for (std::size_t row : tree) chosen.emplace(row, t_.truth(parts.contains(row)));
  return chosen;
}

System::Chosen System::largest(const Rows& tree) const {
  Chosen available, chosen;
  for (auto row = tree.rbegin(); row != tree.rend(); ++row) {
    const Node& node = m_.nodes[*row];
    z3::expr can = node.kind == Kind::Port ? on_[*row] : t_.truth(node.kind == Kind::All);
    for (const Edge& edge : node.children) {
      if (node.kind == Kind::All) can = both(can, available.at(edge.node));
      else if (edge.is_trigger || node.kind == Kind::Any) can = either(can, available.at(edge.node));
    }
    available.emplace(*row, can);
  }
  chosen.emplace(tree[0], available.at(tree[0]));
  for (std::size_t row : tree) {
    // Of alternatives that can, any one: the first that is liked, or the last.
    z3::expr open = chosen.at(row);
    const std::vector<Edge>& children = m_.nodes[row].children;
    for (auto edge = children.begin(); edge != children.end(); ++edge) {
      z3::expr here = m_.nodes[row].kind == Kind::Trigger ? both(open, available.at(edge->node)) : open;
      if (m_.nodes[row].kind == Kind::Any) {
        z3::expr others = t_.truth(false);
        for (auto other = edge + 1; other != children.end(); ++other) others = either(others, available.at(other->node));
        here = both(open, both(available.at(edge->node), either(no(others), t_.fresh("bool"))));
        open = both(open, no(here));
      }
      const auto [at, is_new] = chosen.emplace(edge->node, here);
      if (!is_new) at->second = either(at->second, here);
    }
  }
  return chosen;
}

z3::expr System::clause_is(const Connector& c, const Clause& clause, const Chosen& chosen) const {
  z3::expr here = chosen.at(c.root);
  for (std::size_t p = 0; p < c.params.size(); ++p) {
    const z3::expr& part = chosen.at(c.params[p].node);
    here = both(here, std::find(clause.params.begin(), clause.params.end(), p) != clause.params.end() ? part : no(part));
  }
  return here;
}

// (of ATOM SLOT)
z3::expr& System::data(const Tree& of, Store& store) {
  const std::size_t atom = of.at(1).row();
  return local_of(atom, store).at(m_.type_of(atom).places + of.at(2).row());
}

// `bind` of a connector: the variables of its ports, one after the other, then data of the compound.
Scope System::scope_of(std::size_t connector, const Chosen& chosen, Store& store) {
  const Connector& c = m_.connectors[connector];
  Scope scope{store.frames.at(connector), {}, {}};
  for (std::size_t p = 0; p < c.params.size(); ++p) {
    std::size_t row = c.params[p].node;
    if (m_.nodes[row].kind == Kind::Any) {
      const std::vector<Edge>& of = m_.nodes[row].children;
      const auto taken = std::find_if(of.begin(), of.end(), [&](const Edge& edge) { return is(chosen.at(edge.node), true); });
      row = taken == of.end() ? kNone : m_.nodes[taken->node].children[0].node;
    }
    const std::size_t inner = row == kNone ? kNone : m_.nodes[row].connector;
    const std::vector<Text>& types = m_.port_types.at(m_.connector_types[c.type].params[p]);
    for (std::size_t v = 0; v < types.size(); ++v) {
      if (row == kNone || (inner != kNone && !store.frames.contains(inner))) scope.bind.push_back(&store.any.emplace_back(t_.fresh(types[v])));
      else if (inner != kNone) scope.bind.push_back(&store.frames.at(inner).at(m_.connector_types[m_.connectors[inner].type].exported.at(v)));
      else scope.bind.push_back(&local_of(m_.atom_of_port.at(row), store).at(m_.port(row).variables.at(v)));
    }
  }
  for (const Tree* of : c.data->all("of")) scope.bind.push_back(&data(*of, store));
  return scope;
}

z3::expr System::enabled(const Rows& tree, bool is_listed, const Chosen& chosen, Store& store) {
  z3::expr result = chosen.at(tree[0]);
  for (std::size_t row : tree) {
    if (m_.nodes[row].kind == Kind::Port && is(chosen.at(row), true)) result = both(result, on_[row]);
  }
  const z3::expr there = result;
  // Inner connectors first: what they compute is read above.
  for (auto row = tree.rbegin(); row != tree.rend(); ++row) {
    const std::size_t connector = m_.nodes[*row].connector;
    if (connector == kNone || is(chosen.at(*row), false)) continue;
    const Connector& c = m_.connectors[connector];
    const ConnectorType& type = m_.connector_types[c.type];
    Local& frame = store.frames[connector];
    for (Text slot : type.slots) frame.push_back(t_.first(slot));
    for (const Clause& clause : type.clauses) {
      if (clause.guard->items.size() + clause.up->items.size() == 0) continue;
      const z3::expr here = clause_is(c, clause, chosen);
      if (is(here, false)) continue;
      const Scope read = scope_of(connector, chosen, store);
      z3::expr fault = t_.truth(false), holds = t_.holds(*clause.guard, read, here, fault);
      t_.execute(*clause.up, read, here, fault);
      if (!is(fault, false)) {
        guard_fault_ = either(guard_fault_, both(there, fault));
        holds = z3::ite(fault, t_.fresh("bool"), holds);
      }
      result = both(result, either(no(here), holds));
    }
  }
  // Where only the largest configurations of an inner connector are seen, none that is larger there is enabled.
  for (std::size_t row : is_listed ? tree : Rows()) {
    for (const Edge& edge : m_.nodes[row].children) {
      if (!edge.is_maximal || is(chosen.at(edge.node), false)) continue;
      const Shape& inner = shape_of(edge.node, true);
      if (!inner.is_complete) throw NotCheckable("a connector has too many interactions");
      Parts own;
      std::copy_if(inner.tree.begin(), inner.tree.end(), std::inserter(own, own.end()), [&](std::size_t part) { return is(chosen.at(part), true); });
      for (const Parts& larger : inner.all) {
        Store other;
        if (is_larger(larger, own)) result = both(result, no(enabled(inner.tree, true, choice_of(inner.tree, larger), other)));
      }
    }
  }
  return result;
}

}  // namespace certcheck
