// Candidates, what priorities hide, and what a step does.
#include "tools/certcheck/system.hpp"

#include <algorithm>

namespace certcheck {

void System::look_at(const State& now) {
  now_ = now;
  offers_.clear();
  on_.clear();
  all_.clear();
  is_complete_ = false;
  state_fault_ = guard_fault_ = t_.truth(false);
  for (std::size_t atom = 0; atom < now_.size(); ++atom) {
    offers_.push_back(t_.offer(m_.type_of(atom), now_[atom], state_fault_));
    on_.insert(on_.end(), offers_[atom].ports.begin(), offers_[atom].ports.end());
  }
}

void System::add_candidates(std::size_t node) {
  const Shape& shape = shape_of(node, false);
  const std::size_t first = all_.size(), count = shape.is_plain ? 1 : shape.all.size();
  for (std::size_t k = 0; k < count; ++k) {
    Candidate& c = all_.emplace_back(Candidate{node, shape.is_plain ? largest(shape.tree) : choice_of(shape.tree, shape.all[k]), {}, t_.truth(false), t_.truth(false)});
    c.offered = c.possible = enabled(shape.tree, !shape.is_plain, c.chosen, c.store);
  }
  // Maximal progress: nothing larger is enabled.
  for (std::size_t k = 0; k < count && !shape.is_plain && shape.is_complete; ++k) {
    for (std::size_t j = 0; j < count; ++j) {
      if (is_larger(shape.all[j], shape.all[k])) all_[first + k].possible = both(all_[first + k].possible, no(all_[first + j].offered));
    }
  }
  for (std::size_t k = 0; k < count; ++k) all_[first + k].offered = all_[first + k].possible;
}

z3::expr System::has_step() {
  z3::expr_vector some(state_fault_.ctx());
  is_complete_ = false;
  for (std::size_t node = 0; node < m_.nodes.size(); ++node) {
    all_.clear();
    if (m_.nodes[node].is_step) add_candidates(node);
    for (const Candidate& candidate : all_) some.push_back(candidate.possible);
  }
  all_.clear();
  return z3::mk_or(some);
}

void System::find_candidates() {
  if (is_complete_) return;
  is_complete_ = true;
  for (std::size_t node = 0; node < m_.nodes.size(); ++node) {
    if (!m_.nodes[node].is_step) continue;
    if (!shape_of(node, false).is_complete) throw NotCheckable("a connector has too many interactions");
    add_candidates(node);
  }
  if (!m_.priorities.empty()) hide();
}

z3::expr System::matches(const Tree& rule, bool is_high, const Candidate& c) const {
  const Tree &pattern = rule[is_high ? "high" : "low"], &other = rule[is_high ? "low" : "high"];
  const std::size_t connector = m_.nodes[c.node].connector;
  if (pattern.at(1).text == "any") {
    if (connector == kNone || m_.connectors[connector].compound != rule["in"].at(1).row()) return t_.truth(false);
    return other.at(1).text == "any" ? t_.truth(true) : no(matches(rule, !is_high, c));
  }
  if (pattern.at(1).row() != connector) return t_.truth(false);
  z3::expr result = t_.truth(true);
  if (pattern.at(2).text == "any") return result;
  const Rows named = pattern.rows();
  const std::vector<Edge>& params = m_.connectors[connector].params;
  for (std::size_t p = 0; p < params.size(); ++p) {
    const z3::expr& part = c.chosen.at(params[p].node);
    const bool is_named = std::find(named.begin() + 1, named.end(), p) != named.end();
    if (is_high == is_named) result = both(result, is_high ? part : no(part));
  }
  return result;
}

// A chain goes through interactions that need not be enabled: here through those that are candidates' own, and for connectors
// without guards through none, so that less is hidden than the engine hides and more steps are checked.
void System::hide() {
  const std::size_t count = m_.priorities.size();
  std::vector<z3::expr> guard, hides;
  for (const Tree* rule : m_.priorities) {
    Store store;
    Scope reads;
    for (const Tree* of : (*rule)["data"].all("of")) reads.bind.push_back(&data(*of, store));
    guard.push_back(t_.holds((*rule)["guard"], reads, t_.truth(true), state_fault_));
    z3::expr above = t_.truth(false);
    for (const Candidate& c : all_) above = either(above, both(c.offered, matches(*rule, true, c)));
    hides.push_back(both(guard.back(), above));
  }
  std::vector<std::pair<std::size_t, std::size_t>> chains;
  for (std::size_t r = 0; r < count; ++r) {
    for (std::size_t s = 0; s < count; ++s) {
      const auto meet = [&](const Candidate& c) { return is(matches(*m_.priorities[r], true, c), true) && is(matches(*m_.priorities[s], false, c), true); };
      if (r != s && std::any_of(all_.begin(), all_.end(), meet)) chains.emplace_back(r, s);
    }
  }
  for (std::size_t round = 0; round < count; ++round) {
    const std::vector<z3::expr> before = hides;
    for (const auto& [r, s] : chains) hides[r] = either(hides[r], both(guard[r], before[s]));
  }
  for (Candidate& c : all_) {
    for (std::size_t r = 0; r < count; ++r) c.possible = both(c.possible, no(both(hides[r], matches(*m_.priorities[r], false, c))));
  }
}

// Of a connector the `down`s from the outside in, then the ports in the order of parameters.
void System::fire(const Candidate& candidate, std::size_t node, const z3::expr& when, Store& store, Step& step) {
  if (is(when, false)) return;
  if (m_.nodes[node].connector == kNone) {
    const std::size_t atom = m_.atom_of_port.at(node);
    Local& local = local_of(atom, store);
    t_.fire(m_.type_of(atom), offers_[atom], node - m_.first_port[atom], local, when, step.fault);
    step.next.insert_or_assign(atom, local);
    return;
  }
  const Connector& c = m_.connectors[m_.nodes[node].connector];
  for (const Clause& clause : m_.connector_types[c.type].clauses) {
    if (clause.down->items.empty()) continue;
    t_.execute(*clause.down, scope_of(m_.nodes[node].connector, candidate.chosen, store), clause_is(c, clause, candidate.chosen), step.fault);
  }
  // A port may be chosen below another alternative.
  const auto part = [&](std::size_t chosen, std::size_t row) { fire(candidate, row, both(candidate.chosen.at(node), candidate.chosen.at(chosen)), store, step); };
  for (const Edge& edge : c.params) {
    if (m_.nodes[edge.node].kind != Kind::Any) part(edge.node, edge.node);
    else for (const Edge& one : m_.nodes[edge.node].children) part(one.node, m_.nodes[one.node].children[0].node);
  }
}

void System::each_step(const std::function<void(const Step&)>& visit) {
  find_candidates();
  for (const Candidate& c : all_) {
    if (is(c.possible, false)) continue;
    Step step{c.possible, c.offered, t_.truth(false), {}};
    Store store = c.store;
    fire(c, c.node, c.chosen.at(c.node), store, step);
    visit(step);
  }
}

z3::expr System::claim(const Tree& e) {
  Scope said;
  said.about = [this](const Tree& about) {
    const Text path = about.at(1).text, what = about.head();
    for (std::size_t c = 0; what == "can" && c < m_.connectors.size(); ++c) {
      if (m_.connectors[c].path != path) continue;
      find_candidates();
      z3::expr some = t_.truth(false);
      for (const Candidate& candidate : all_) some = m_.nodes[candidate.node].connector == c ? either(some, candidate.possible) : some;
      return some;
    }
    for (std::size_t a = 0; what != "can" && a < m_.atoms.size(); ++a) {
      if (m_.atoms[a].path != path) continue;
      const AtomType& type = m_.type_of(a);
      const auto is_it = [&](const Port& port) { return port.name == about.at(2).text; };
      const auto port = static_cast<std::size_t>(std::find_if(type.ports.begin(), type.ports.end(), is_it) - type.ports.begin());
      const std::size_t row = what == "can-port" ? m_.first_port[a] + port : find_variable(type, about.at(2).text, what == "at");
      if (what == "can-port" ? port < type.ports.size() : row != kNone) return what == "can-port" ? on_[row] : now_[a][row];
    }
    throw Rejected("the claim names something of `" + std::string(path) + "` that there is not");
  };
  z3::expr fault = t_.truth(false);
  return t_.evaluate(e, said, t_.truth(true), fault);
}

}  // namespace certcheck
