// Connectors' trees: their configurations, who takes part in one, and whether guards and maximal progress allow it.
#include <algorithm>

#include "tools/certcheck/system.hpp"

namespace certcheck {

namespace {
constexpr std::size_t kMaxConfigurations = 512;
// Divisions and calls.
bool may_fault(const Tree* body) {
  if (body == nullptr) return false;
  if (body->head() == "div" || body->head() == "mod" || body->head() == "call") return true;
  return std::any_of(body->items.begin(), body->items.end(), [](const Tree& item) { return may_fault(&item); });
}
}  // namespace

// Parents before children.
Rows System::tree_of(std::size_t root) const {
  Rows tree{root};
  for (std::size_t k = 0; k < tree.size(); ++k) {
    for (const Edge& edge : m_.nodes[tree[k]].children) tree.push_back(edge.node);
  }
  std::sort(tree.rbegin(), tree.rend());
  tree.erase(std::unique(tree.begin(), tree.end()), tree.end());
  return tree;
}

bool System::is_shared(const Rows& tree) const {
  std::set<std::size_t> seen;
  for (std::size_t row : tree) {
    for (const Edge& edge : m_.nodes[row].children) {
      if (!seen.insert(edge.node).second) return true;
    }
  }
  return false;
}

// Any choice of alternatives fits: two ports of an atom, or one port in two places, are in alternatives to each other; and where those
// share ports, they are rendezvous of which none is a part of another.
bool System::has_free_choices(const Rows& tree) const {
  std::map<std::size_t, std::size_t> parent;  // of all but ports
  std::map<std::size_t, std::vector<std::pair<std::size_t, std::size_t>>> ports;  // by atom: port, node above
  for (std::size_t row : tree) {
    for (const Edge& edge : m_.nodes[row].children) {
      if (m_.nodes[edge.node].kind == Kind::Port) ports[m_.atom_of_port[edge.node]].emplace_back(edge.node, row);
      else if (!parent.emplace(edge.node, row).second) return false;
    }
  }
  const auto meet = [&](std::size_t one, std::size_t other) {
    Rows above{one};
    for (auto up = parent.find(one); up != parent.end(); up = parent.find(up->second)) above.push_back(up->second);
    while (std::find(above.begin(), above.end(), other) == above.end()) other = parent.at(other);
    return other;
  };
  std::set<std::size_t> sharing;
  for (const auto& [atom, uses] : ports) {
    for (std::size_t k = 1; k < uses.size(); ++k) {
      for (std::size_t j = 0; j < k; ++j) {
        const std::size_t above = meet(uses[j].second, uses[k].second);
        const bool is_same = uses[j].first == uses[k].first;
        if (m_.nodes[above].kind != Kind::Any && (is_same || has_choice(tree))) return false;
        if (is_same) sharing.insert(above);
      }
    }
  }
  for (std::size_t row : sharing) {
    std::vector<std::set<std::size_t>> parts;
    for (const Edge& edge : m_.nodes[row].children) {
      parts.emplace_back();
      for (std::size_t below : tree_of(edge.node)) {
        if (m_.nodes[below].kind == Kind::Port) parts.back().insert(below);
        else if (m_.nodes[below].kind != Kind::All) return false;
      }
    }
    for (const auto& one : parts) {
      for (const auto& other : parts) {
        if (one.size() < other.size() && std::includes(other.begin(), other.end(), one.begin(), one.end())) return false;
      }
    }
  }
  return true;
}

// The largest interactions are all that matter: no guards, no errors, and free choices at which no code looks.
bool System::is_plain(const Rows& tree) const {
  if (!has_free_choices(tree)) return false;
  for (std::size_t row : tree) {
    const Node& node = m_.nodes[row];
    if (node.connector == kNone) continue;
    const Connector& c = m_.connectors[node.connector];
    const bool chooses = std::any_of(c.params.begin(), c.params.end(), [&](const Edge& edge) { return m_.nodes[edge.node].kind == Kind::Any; });
    for (const Tree& item : c.type->items) {
      if (item.head() != "clause") continue;
      if ((item.find("guard") != nullptr && item.find("guard")->items.at(1).text != "true") || may_fault(item.find("up"))) return false;
      if (chooses && (item.find("up") != nullptr || item.find("down") != nullptr)) return false;
    }
  }
  return true;
}
bool System::has_choice(const Rows& tree) const {
  return std::any_of(tree.begin(), tree.end(), [&](std::size_t row) { return m_.nodes[row].kind == Kind::Any; });
}

bool System::list(std::size_t row, Want want, std::vector<Leaves>& out) const {
  const Node& node = m_.nodes[row];
  if (node.kind == Kind::Port) {
    out.push_back({row});
    return true;
  }
  const bool is_one = node.kind == Kind::Any || (node.kind == Kind::Trigger && want == Want::Smallest);
  std::vector<std::pair<Leaves, bool>> found{{{}, node.kind == Kind::All}};
  for (const Edge& edge : node.children) {
    if (is_one && node.kind == Kind::Trigger && !edge.is_trigger) continue;
    std::vector<Leaves> inner;
    if (!list(edge.node, want, inner)) return false;
    if (is_one) {
      out.insert(out.end(), inner.begin(), inner.end());
      continue;
    }
    std::vector<std::pair<Leaves, bool>> next;
    if (node.kind == Kind::Trigger) next = found;
    for (const auto& [leaves, is_good] : found) {
      for (const Leaves& more : inner) {
        next.emplace_back(leaves, is_good || edge.is_trigger);
        next.back().first.insert(more.begin(), more.end());
      }
    }
    if (next.size() > 2 * kMaxConfigurations) return false;
    found = std::move(next);
  }
  for (const auto& [leaves, is_good] : found) {
    if (!is_one && is_good && !leaves.empty()) out.push_back(leaves);
  }
  return out.size() <= kMaxConfigurations;
}

System::Chosen System::fixed(const Rows& tree, const Leaves& leaves) const {
  Chosen chosen;
  for (auto row = tree.rbegin(); row != tree.rend(); ++row) {
    const std::vector<Edge>& children = m_.nodes[*row].children;
    const auto takes_part = [&](const Edge& e) { return is(chosen.at(e.node), true); };
    // Of a rendezvous all or none; where it is one of several with the same port, all say that it is this one.
    const bool is_all = m_.nodes[*row].kind == Kind::All && std::all_of(children.begin(), children.end(), takes_part);
    const bool is_some = m_.nodes[*row].kind != Kind::All && std::any_of(children.begin(), children.end(), takes_part);
    chosen.emplace(*row, t_.truth(leaves.contains(*row) || is_all || is_some));
  }
  return chosen;
}

System::Chosen System::largest(const Rows& tree, std::size_t root) const {
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
  chosen.emplace(root, available.at(root));
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

// Of a merged port the one that takes part, or itself: none is known to.
std::size_t System::param_node(std::size_t node, const Chosen& chosen) const {
  if (m_.nodes[node].kind != Kind::Any) return node;
  for (const Edge& edge : m_.nodes[node].children) {
    if (is(chosen.at(edge.node), true)) return edge.node;
  }
  return node;
}

z3::expr System::clause_is(const Connector& c, const Tree& clause, const Chosen& chosen) const {
  const Rows wanted = rows_of(clause.find("params"));
  z3::expr here = chosen.at(c.root);
  for (std::size_t p = 0; p < c.params.size(); ++p) {
    const z3::expr& part = chosen.at(c.params[p].node);
    here = both(here, std::find(wanted.begin(), wanted.end(), p) != wanted.end() ? part : no(part));
  }
  return here;
}

// `bind` of a connector: the variables of its ports, one after the other, then data of the compound.
Variables System::variables(std::size_t connector, const Chosen& chosen, Store& store) {
  struct Place {
    enum { Nowhere, Atom, Frame } where = Nowhere;
    std::size_t owner = 0, slot = 0;
    std::string type;  // Nowhere
  };
  const Connector& c = m_.connectors[connector];
  auto places = std::make_shared<std::vector<Place>>();
  std::size_t param = 0;
  for (const Tree& item : c.type->items) {
    if (item.head() != "param") continue;
    const std::size_t row = param_node(c.params.at(param++).node, chosen);
    const Node& node = m_.nodes[row];
    const std::vector<std::string>& types = m_.port_types.at(item.items.at(3).row());
    const Rows exported = node.connector == kNone ? Rows() : rows_of(m_.connectors[node.connector].type->find("export")->find("slots"));
    for (std::size_t v = 0; v < types.size(); ++v) {
      if (node.kind == Kind::Any) {
        places->push_back({Place::Nowhere, 0, 0, types[v]});
      } else if (node.connector != kNone) {
        places->push_back({Place::Frame, node.connector, exported.at(v), {}});
      } else {
        const std::size_t atom = m_.atom_of_port.at(row);
        places->push_back({Place::Atom, atom, m_.type_of(atom).port_slots[row - m_.first_port[atom]].at(v), {}});
      }
    }
  }
  for (std::size_t k = 1; c.data != nullptr && k < c.data->items.size(); ++k) places->push_back({Place::Atom, c.data->items[k].items.at(1).row(), c.data->items[k].items.at(2).row(), {}});
  Variables v;
  v.self = [&store, connector](std::size_t k) { return store.frames.at({connector, k}); };
  v.set_self = [&store, connector](std::size_t k, const z3::expr& value) { store.frames.insert_or_assign({connector, k}, value); };
  v.bind = [this, places, &store](std::size_t k) {
    const Place& p = places->at(k);
    if (p.where == Place::Frame) return store.frames.at({p.owner, p.slot});
    return p.where == Place::Nowhere ? t_.fresh(p.type) : t_.own(m_.type_of(p.owner), local_of(p.owner, store)).self(p.slot);
  };
  v.set_bind = [this, places, &store](std::size_t k, const z3::expr& value) {
    const Place& p = places->at(k);
    if (p.where == Place::Frame) store.frames.insert_or_assign({p.owner, p.slot}, value);
    if (p.where == Place::Atom) local_of(p.owner, store).slots.at(p.slot) = value;
  };
  return v;
}

// Null leaves: the largest, whose ports are enabled where it is chosen.
z3::expr System::enabled(const Rows& tree, std::size_t root, const Leaves* leaves, const Chosen& chosen, Store& store) {
  z3::expr result = chosen.at(root);
  for (std::size_t leaf : leaves == nullptr ? Leaves() : *leaves) result = both(result, on_[leaf]);
  const z3::expr there = result;
  // Inner connectors first: what they compute is read above.
  for (auto row = tree.rbegin(); row != tree.rend(); ++row) {
    const std::size_t connector = m_.nodes[*row].connector;
    if (connector == kNone || is(chosen.at(*row), false)) continue;
    const Connector& c = m_.connectors[connector];
    for (const Tree& item : c.type->items) {
      if (item.head() == "slot") store.frames.insert_or_assign({connector, item.items.at(1).row()}, t_.first(item.items.at(3).text));
    }
    const Variables v = variables(connector, chosen, store);
    for (const Tree& clause : c.type->items) {
      if (clause.head() != "clause") continue;
      const z3::expr here = clause_is(c, clause, chosen);
      if (is(here, false)) continue;
      z3::expr fault = t_.truth(false), holds = t_.truth(true);
      if (const Tree* guard = clause.find("guard")) holds = t_.evaluate(guard->items.at(1), v, here, fault);
      t_.execute(clause.find("up"), 1, v, here, fault);
      if (!is(fault, false)) {
        guard_fault_ = either(guard_fault_, both(there, fault));
        holds = z3::ite(fault, t_.fresh("bool"), holds);
      }
      result = both(result, either(no(here), holds));
    }
  }
  for (std::size_t row : leaves == nullptr ? Rows() : tree) {
    for (const Edge& edge : m_.nodes[row].children) {
      if (!edge.is_maximal || is(chosen.at(edge.node), false)) continue;
      const Rows inner = tree_of(edge.node);
      Leaves own;
      std::copy_if(leaves->begin(), leaves->end(), std::inserter(own, own.end()), [&](std::size_t leaf) { return std::find(inner.begin(), inner.end(), leaf) != inner.end(); });
      std::vector<Leaves> all;
      if (!list(edge.node, Want::All, all)) throw NotCheckable("a connector has too many interactions");
      for (const Leaves& larger : all) {
        if (larger.size() <= own.size() || !std::includes(larger.begin(), larger.end(), own.begin(), own.end())) continue;
        Store other;
        result = both(result, no(enabled(inner, edge.node, &larger, fixed(inner, larger), other)));
      }
    }
  }
  return result;
}

}  // namespace certcheck
