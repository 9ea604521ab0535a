// Which configurations are candidates, after guards, maximal progress and priorities, and what a step does, over Z3 terms.
#include <algorithm>

#include "tools/certcheck/symbolic.hpp"

namespace certcheck {

namespace {
bool is(const z3::expr& e, bool value) { return value ? e.is_true() : e.is_false(); }
bool fits_within(const std::set<std::size_t>& a, const std::set<std::size_t>& b) { return std::includes(b.begin(), b.end(), a.begin(), a.end()); }
}  // namespace

Variables Symbolic::variables(const Expanded& tree, std::size_t use, const std::vector<z3::expr>& chosen, Store& store) {
  struct Place {
    enum { Nowhere, Atom, Frame } where = Nowhere;
    std::size_t owner = 0, slot = 0;
    std::string type;  // Nowhere
  };
  const Use& of = tree.uses[use];
  const Connector& c = m_.connectors[of.connector];
  const Tree& type = *m_.connector_types[c.type];
  auto places = std::make_shared<std::vector<Place>>();
  std::size_t param = 0;
  for (const Tree& item : type.items) {
    if (item.head() != "param") continue;
    std::size_t row = of.params.at(param++);
    bool is_known = true;
    if (tree.parts[row].kind == Kind::Any) {
      is_known = false;
      for (std::size_t child : std::vector<std::size_t>(tree.parts[row].children)) {
        if (!is(chosen[child], true)) continue;
        row = child;
        is_known = true;
      }
    }
    const Part& part = tree.parts[row];
    const Tree* exported = part.is_link ? m_.connector_types[m_.connectors[tree.uses[part.use].connector].type]->find("export")->find("slots") : nullptr;
    for (std::size_t v = 0; v < m_.port_type_sizes.at(item.items.at(3).row()); ++v) {
      if (!is_known) places->push_back({Place::Nowhere, 0, 0, m_.port_type_types.at(item.items[3].row()).at(v)});
      else if (part.is_link) places->push_back({Place::Frame, part.use, exported->items.at(1 + v).row(), {}});
      else places->push_back({Place::Atom, m_.atom_of_port[part.port], m_.atom_types[m_.atoms[m_.atom_of_port[part.port]].type].port_slots.at(part.port - m_.first_port[m_.atom_of_port[part.port]]).at(v), {}});
    }
  }
  for (std::size_t k = 1; c.data != nullptr && k < c.data->items.size(); ++k) places->push_back({Place::Atom, c.data->items[k].items.at(1).row(), c.data->items[k].items.at(2).row(), {}});
  const auto frame = [this, &store](std::size_t owner, std::size_t slot) { return store.frames.at({owner, slot}); };
  Variables v;
  v.self = [=](std::size_t k) { return frame(use, k); };
  v.set_self = [&store, use](std::size_t k, const z3::expr& value) { store.frames.insert_or_assign({use, k}, value); };
  v.bind = [this, places, &store, frame](std::size_t k) {
    const Place& p = places->at(k);
    if (p.where == Place::Frame) return frame(p.owner, p.slot);
    if (p.where == Place::Nowhere) return fresh(p.type);
    const AtomType& owner = m_.atom_types[m_.atoms[p.owner].type];
    Local& local = store.atoms.try_emplace(p.owner, now_[p.owner]).first->second;
    return own(owner, local).self(p.slot);
  };
  v.set_bind = [this, places, &store](std::size_t k, const z3::expr& value) {
    const Place& p = places->at(k);
    if (p.where == Place::Frame) store.frames.insert_or_assign({p.owner, p.slot}, value);
    if (p.where == Place::Atom) store.atoms.try_emplace(p.owner, now_[p.owner]).first->second.slots.at(p.slot) = value;
  };
  return v;
}

z3::expr Symbolic::clause_is(const Use& use, const Tree& clause, const std::vector<z3::expr>& chosen) {
  std::set<std::size_t> wanted;
  const Tree* params = clause.find("params");
  for (std::size_t k = 1; params != nullptr && k < params->items.size(); ++k) wanted.insert(params->items[k].row());
  z3::expr here = chosen[use.root];
  for (std::size_t p = 0; p < use.params.size(); ++p) here = (here && (wanted.contains(p) ? chosen[use.params[p]] : !chosen[use.params[p]])).simplify();
  return here;
}

z3::expr Symbolic::enabled(const Expanded& tree, std::size_t root, const Leaves* leaves, const std::vector<z3::expr>& chosen, Store& store) {
  z3::expr result = chosen[root];
  if (leaves != nullptr) {
    for (std::size_t leaf : *leaves) result = (result && on_[tree.parts[leaf].port]).simplify();
  }
  const z3::expr there = result;
  for (std::size_t u = tree.uses.size(); u-- > 0;) {
    const Use& use = tree.uses[u];
    if (is(chosen[use.root], false) || !below(tree, root, use.root)) continue;
    const Tree& type = *m_.connector_types[m_.connectors[use.connector].type];
    for (const Tree& item : type.items) {
      if (item.head() != "slot") continue;
      const std::string& name = item.items.at(3).text;
      store.frames.insert_or_assign({u, item.items.at(1).row()}, name == "int" || name == "bool" || name == "string" ? zero(name) : fresh(name));
    }
    const Variables v = variables(tree, u, chosen, store);
    for (const Tree& clause : type.items) {
      if (clause.head() != "clause") continue;
      const z3::expr here = clause_is(use, clause, chosen);
      if (is(here, false)) continue;
      z3::expr fault = truth(false), holds = truth(true);
      if (const Tree* guard = clause.find("guard")) holds = evaluate(guard->items.at(1), v, here, fault);
      execute(clause.find("up"), 1, v, here, fault);
      if (!is(fault, false)) {
        guard_fault_ = *guard_fault_ || (there && fault);
        holds = z3::ite(fault, fresh("bool"), holds);
      }
      result = (result && (!here || holds)).simplify();
    }
  }
  for (std::size_t row = 0; leaves != nullptr && row < tree.parts.size(); ++row) {
    if (!tree.parts[row].maximal || is(chosen[row], false) || row == root || !below(tree, root, row)) continue;
    const std::size_t inner = tree.parts[row].children[0];
    std::vector<Leaves> all;
    if (!list(tree, inner, all)) throw NotCheckable("a connector has too many interactions");
    Leaves own_leaves;
    for (std::size_t leaf : *leaves) {
      if (below(tree, inner, leaf)) own_leaves.insert(leaf);
    }
    for (const Leaves& larger : all) {
      if (larger.size() <= own_leaves.size() || !fits_within(own_leaves, larger)) continue;
      Store other;
      result = (result && !enabled(tree, inner, &larger, fixed(tree, larger), other)).simplify();
    }
  }
  return result;
}

bool Symbolic::candidates(std::size_t connector, std::vector<Candidate>& out) {
  Expanded tree;
  (void)add_use(tree, connector, 0);
  const std::size_t root = tree.uses[0].root;
  if (tree.is_plain) {
    Candidate c{connector, tree, largest(tree), {}, truth(false)};
    c.possible = enabled(tree, root, nullptr, c.chosen, c.store);
    out.push_back(std::move(c));
    return true;
  }
  std::vector<Leaves> all;
  if (!list(tree, root, all)) return false;
  const std::size_t first = out.size();
  std::vector<z3::expr> on;
  for (const Leaves& leaves : all) {
    Candidate c{connector, tree, fixed(tree, leaves), {}, truth(false)};
    on.push_back(enabled(tree, root, &leaves, c.chosen, c.store));
    out.push_back(std::move(c));
  }
  for (std::size_t k = 0; k < all.size(); ++k) {
    z3::expr possible = on[k];
    for (std::size_t j = 0; j < all.size(); ++j) {
      if (all[j].size() > all[k].size() && fits_within(all[k], all[j])) possible = (possible && !on[j]).simplify();
    }
    out[first + k].possible = possible;
  }
  return true;
}

z3::expr Symbolic::connector_can(std::size_t connector) {
  (void)steps();
  z3::expr_vector some(z_);
  for (const Candidate& c : all_) {
    if (c.connector == connector) some.push_back(c.possible);
  }
  return z3::mk_or(some);
}

z3::expr Symbolic::matches(const Tree& rule, const char* side, const Candidate& c) {
  const bool high = std::string_view(side) == "high";
  const Tree& pattern = *rule.find(side);
  const Tree& other = *rule.find(high ? "low" : "high");
  if (pattern.items.at(1).text == "any") {
    if (m_.connectors[c.connector].compound != rule.find("in")->items.at(1).row()) return truth(false);
    return other.items.at(1).text == "any" ? truth(true) : !matches(rule, high ? "low" : "high", c);
  }
  if (pattern.items[1].row() != c.connector) return truth(false);
  if (pattern.items.at(2).text == "any") return truth(true);
  std::set<std::size_t> named;
  for (std::size_t k = 2; k < pattern.items.size(); ++k) named.insert(pattern.items[k].row());
  z3::expr result = truth(true);
  const Use& use = c.tree.uses[0];
  for (std::size_t p = 0; p < use.params.size(); ++p) {
    if (high && named.contains(p)) result = (result && c.chosen[use.params[p]]).simplify();
    if (!high && !named.contains(p)) result = (result && !c.chosen[use.params[p]]).simplify();
  }
  return result;
}

// A chain goes through interactions that need not be enabled: here through those that are candidates' own, and for connectors
// without guards through none, so that less is hidden than the engine hides and more steps are checked.
void Symbolic::hide_candidates() {
  const std::size_t count = m_.priorities.size();
  std::vector<z3::expr> guard, hides;
  for (const Tree* rule : m_.priorities) {
    Variables v;
    const Tree* data = rule->find("data");
    v.bind = [&](std::size_t k) {
      const Tree& of = data->items.at(1 + k);
      Local& local = now_.at(of.items.at(1).row());
      return own(m_.atom_types[m_.atoms[of.items[1].row()].type], local).self(of.items.at(2).row());
    };
    const Tree* condition = rule->find("guard");
    guard.push_back(condition == nullptr ? truth(true) : evaluate(condition->items.at(1), v, truth(true), *state_fault_));
    z3::expr above = truth(false);
    for (const Candidate& c : all_) above = (above || (c.possible && matches(*rule, "high", c))).simplify();
    hides.push_back((guard.back() && above).simplify());
  }
  for (std::size_t round = 0; round < count; ++round) {
    std::vector<z3::expr> next = hides;
    for (std::size_t r = 0; r < count; ++r) {
      for (std::size_t s = 0; s < count; ++s) {
        const bool meet = r != s && std::any_of(all_.begin(), all_.end(), [&](const Candidate& c) {
          return is(matches(*m_.priorities[r], "high", c), true) && is(matches(*m_.priorities[s], "low", c), true);
        });
        if (meet) next[r] = (next[r] || (guard[r] && hides[s])).simplify();
      }
    }
    hides = next;
  }
  std::vector<z3::expr> visible;
  for (const Candidate& c : all_) {
    z3::expr here = c.possible;
    for (std::size_t r = 0; r < count; ++r) here = (here && !(hides[r] && matches(*m_.priorities[r], "low", c))).simplify();
    visible.push_back(here);
  }
  for (std::size_t k = 0; k < all_.size(); ++k) all_[k].possible = visible[k];
}

void Symbolic::fire_use(const Candidate& c, std::size_t use, Store& store, Step& step) {
  const Use& of = c.tree.uses[use];
  for (const Tree& clause : m_.connector_types[m_.connectors[of.connector].type]->items) {
    if (clause.head() == "clause") execute(clause.find("down"), 1, variables(c.tree, use, c.chosen, store), clause_is(of, clause, c.chosen), step.fault);
  }
  for (std::size_t row : of.params) {
    if (is(c.chosen[row], false)) continue;
    if (c.tree.parts[row].kind == Kind::Any) {
      for (std::size_t child : std::vector<std::size_t>(c.tree.parts[row].children)) {
        if (is(c.chosen[child], true)) row = child;
      }
    }
    const Part& part = c.tree.parts[row];
    if (part.is_link) {
      fire_use(c, part.use, store, step);
    } else {
      Local& local = store.atoms.try_emplace(m_.atom_of_port[part.port], now_[m_.atom_of_port[part.port]]).first->second;
      fire(part.port, local, c.chosen[row], step.fault, step.lost);
      step.next.insert_or_assign(m_.atom_of_port[part.port], local);
    }
  }
}

std::vector<Step> Symbolic::steps() {
  if (!is_complete_) {
    for (std::size_t c = 0; c < m_.connectors.size(); ++c) {
      if (m_.nodes[m_.connectors[c].root].is_step && !candidates(c, all_)) throw NotCheckable("a connector has too many interactions");
    }
    hide_candidates();
    is_complete_ = true;
  }
  std::vector<Step> result;
  for (const Candidate& c : all_) {
    if (is(c.possible, false)) continue;
    result.push_back({c.possible, truth(false), truth(false), {}});
    Store store = c.store;
    fire_use(c, 0, store, result.back());
  }
  for (std::size_t port = 0; port < on_.size(); ++port) {
    if (!m_.nodes[port].is_step || is(on_[port], false)) continue;
    result.push_back({on_[port], truth(false), truth(false), {}});
    Local local = now_[m_.atom_of_port[port]];
    fire(port, local, truth(true), result.back().fault, result.back().lost);
    result.back().next.insert_or_assign(m_.atom_of_port[port], local);
  }
  return result;
}

}  // namespace certcheck
