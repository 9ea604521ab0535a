// Connectors' trees: their configurations, who takes part in one, and whether guards and maximal progress allow it.
#include <algorithm>

#include "tools/certcheck/system.hpp"

namespace certcheck {

namespace {
constexpr std::size_t kMaxConfigurations = 512;
}  // namespace

Rows System::tree_of(std::size_t root) const {
  Rows tree{root};
  for (std::size_t k = 0; k < tree.size(); ++k) {
    for (const Edge& edge : m_.nodes[tree[k]].children) tree.push_back(edge.node);
  }
  std::sort(tree.rbegin(), tree.rend());
  tree.erase(std::unique(tree.begin(), tree.end()), tree.end());
  return tree;
}

const System::Shape& System::shape_of(std::size_t connector, bool wants_list) {
  std::optional<Shape>& shape = shapes_[connector];
  const std::size_t root = m_.connectors[connector].root;
  if (!shape) {
    shape.emplace(Shape{tree_of(root), false, false, true, {}});
    shape->is_plain = is_plain(shape->tree);
  }
  if (shape->is_listed || (shape->is_plain && !wants_list)) return *shape;
  shape->is_listed = true;
  shape->is_complete = list(root, false, shape->all);
  if (!shape->is_complete) shape->all.clear();
  if (!shape->is_complete && !list(root, true, shape->all)) shape->all.clear();
  return *shape;
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
      if ((!clause.guard->items.empty() && clause.guard->at(1).text != "true") || clause.up->contains({"div", "mod", "call"})) return false;
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

// `bind` of a connector: the variables of its ports, one after the other, then data of the compound.
Variables System::variables(std::size_t connector, const Chosen& chosen, Store& store) {
  struct Place {
    bool is_frame = false;
    std::size_t owner = kNone, slot = 0;  // kNone: of a merged port of which none is known to take part
    std::string_view type;
  };
  const Connector& c = m_.connectors[connector];
  auto places = std::make_shared<std::vector<Place>>();
  for (std::size_t p = 0; p < c.params.size(); ++p) {
    std::size_t row = c.params[p].node;
    if (m_.nodes[row].kind == Kind::Any) {
      const std::vector<Edge>& of = m_.nodes[row].children;
      const auto taken = std::find_if(of.begin(), of.end(), [&](const Edge& edge) { return is(chosen.at(edge.node), true); });
      row = taken == of.end() ? kNone : m_.nodes[taken->node].children[0].node;
    }
    const std::size_t inner = row == kNone ? kNone : m_.nodes[row].connector;
    const std::vector<std::string_view>& types = m_.port_types.at(m_.connector_types[c.type].params[p]);
    for (std::size_t v = 0; v < types.size(); ++v) {
      if (row == kNone) {
        places->push_back({false, kNone, 0, types[v]});
      } else if (inner != kNone) {
        places->push_back({true, inner, m_.connector_types[m_.connectors[inner].type].exported.at(v), {}});
      } else {
        const std::size_t atom = m_.atom_of_port.at(row);
        places->push_back({false, atom, m_.type_of(atom).port_slots[row - m_.first_port[atom]].at(v), {}});
      }
    }
  }
  for (const Tree* of : c.data->all("of")) places->push_back({false, of->at(1).row(), of->at(2).row(), {}});
  Variables v;
  v.self = [&store, connector](std::size_t k) { return store.frames.at({connector, k}); };
  v.set_self = [&store, connector](std::size_t k, const z3::expr& value) { store.frames.insert_or_assign({connector, k}, value); };
  v.bind = [this, places, &store](std::size_t k) {
    const Place& p = places->at(k);
    if (p.is_frame) return store.frames.at({p.owner, p.slot});
    return p.owner == kNone ? t_.fresh(p.type) : t_.own(m_.type_of(p.owner), local_of(p.owner, store)).self(p.slot);
  };
  v.set_bind = [this, places, &store](std::size_t k, const z3::expr& value) {
    const Place& p = places->at(k);
    if (p.is_frame) store.frames.insert_or_assign({p.owner, p.slot}, value);
    else if (p.owner != kNone) local_of(p.owner, store).slots.at(p.slot) = value;
  };
  return v;
}

z3::expr System::enabled(const Rows& tree, const Parts* parts, const Chosen& chosen, Store& store) {
  z3::expr result = chosen.at(tree[0]);
  for (std::size_t part : parts == nullptr ? Parts() : *parts) {
    if (m_.nodes[part].kind == Kind::Port) result = both(result, on_[part]);
  }
  const z3::expr there = result;
  // Inner connectors first: what they compute is read above.
  for (auto row = tree.rbegin(); row != tree.rend(); ++row) {
    const std::size_t connector = m_.nodes[*row].connector;
    if (connector == kNone || is(chosen.at(*row), false)) continue;
    const Connector& c = m_.connectors[connector];
    const ConnectorType& type = m_.connector_types[c.type];
    for (std::size_t slot = 0; slot < type.slots.size(); ++slot) store.frames.insert_or_assign({connector, slot}, t_.first(type.slots[slot]));
    for (const Clause& clause : type.clauses) {
      if (clause.guard->items.size() + clause.up->items.size() == 0) continue;
      const z3::expr here = clause_is(c, clause, chosen);
      if (is(here, false)) continue;
      const Variables v = variables(connector, chosen, store);
      z3::expr fault = t_.truth(false), holds = t_.holds(*clause.guard, v, here, fault);
      t_.execute(*clause.up, v, here, fault);
      if (!is(fault, false)) {
        guard_fault_ = either(guard_fault_, both(there, fault));
        holds = z3::ite(fault, t_.fresh("bool"), holds);
      }
      result = both(result, either(no(here), holds));
    }
  }
  // Where only the largest configurations of an inner connector are seen, none that is larger there is enabled.
  for (std::size_t row : parts == nullptr ? Rows() : tree) {
    for (const Edge& edge : m_.nodes[row].children) {
      if (!edge.is_maximal || is(chosen.at(edge.node), false)) continue;
      const Shape& inner = shape_of(m_.nodes[edge.node].connector, true);
      if (!inner.is_complete) throw NotCheckable("a connector has too many interactions");
      Parts own;
      std::copy_if(parts->begin(), parts->end(), std::inserter(own, own.end()), [&](std::size_t part) { return std::binary_search(inner.tree.rbegin(), inner.tree.rend(), part); });
      for (const Parts& larger : inner.all) {
        if (larger.size() <= own.size() || !std::includes(larger.begin(), larger.end(), own.begin(), own.end())) continue;
        Chosen also;
        for (std::size_t part : inner.tree) also.emplace(part, t_.truth(larger.contains(part)));
        Store other;
        result = both(result, no(enabled(inner.tree, &larger, also, other)));
      }
    }
  }
  return result;
}

}  // namespace certcheck
