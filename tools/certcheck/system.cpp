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

void System::add_candidates(std::size_t connector) {
  const Shape& shape = shape_of(connector);
  if (shape.is_plain) {
    Candidate c{connector, largest(shape.tree), {}, t_.truth(false), t_.truth(false)};
    c.possible = enabled(shape.tree, nullptr, c.chosen, c.store);
    all_.push_back(std::move(c));
    return;
  }
  std::vector<z3::expr> on;
  const std::size_t first = all_.size(), count = shape.all.size();
  for (const Parts& parts : shape.all) {
    Candidate c{connector, {}, {}, t_.truth(false), t_.truth(false)};
    for (std::size_t row : shape.tree) c.chosen.emplace(row, t_.truth(parts.contains(row)));
    on.push_back(enabled(shape.tree, &parts, c.chosen, c.store));
    all_.push_back(std::move(c));
  }
  // Maximal progress: nothing larger is enabled.
  for (std::size_t k = 0; k < count; ++k) {
    z3::expr& possible = all_[first + k].possible = on[k];
    const Parts& mine = shape.all[k];
    for (std::size_t j = 0; j < count && shape.is_complete; ++j) {
      const Parts& other = shape.all[j];
      if (other.size() > mine.size() && std::includes(other.begin(), other.end(), mine.begin(), mine.end())) possible = both(possible, no(on[j]));
    }
  }
}

z3::expr System::has_step() {
  z3::expr_vector some(state_fault_.ctx());
  for (std::size_t port = 0; port < on_.size(); ++port) {
    if (m_.nodes[port].is_step) some.push_back(on_[port]);
  }
  for (std::size_t c = 0; c < m_.connectors.size(); ++c) {
    all_.clear();
    if (m_.nodes[m_.connectors[c].root].is_step) add_candidates(c);
    for (const Candidate& candidate : all_) some.push_back(candidate.possible);
  }
  all_.clear();
  is_complete_ = false;
  return z3::mk_or(some);
}

void System::find_candidates() {
  if (is_complete_) return;
  is_complete_ = true;
  for (std::size_t c = 0; c < m_.connectors.size(); ++c) {
    if (!m_.nodes[m_.connectors[c].root].is_step) continue;
    if (!shape_of(c).is_complete) throw NotCheckable("a connector has too many interactions");
    add_candidates(c);
  }
  for (Candidate& c : all_) c.offered = c.possible;
  if (!m_.priorities.empty()) hide();
}

z3::expr System::matches(const Tree& rule, bool is_high, const Candidate& c) const {
  const Tree &pattern = rule[is_high ? "high" : "low"], &other = rule[is_high ? "low" : "high"];
  if (pattern.at(1).text == "any") {
    if (m_.connectors[c.connector].compound != rule["in"].at(1).row()) return t_.truth(false);
    return other.at(1).text == "any" ? t_.truth(true) : no(matches(rule, !is_high, c));
  }
  if (pattern.at(1).row() != c.connector) return t_.truth(false);
  z3::expr result = t_.truth(true);
  if (pattern.at(2).text == "any") return result;
  const Rows named = pattern.rows();
  const std::vector<Edge>& params = m_.connectors[c.connector].params;
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
    Variables v;
    v.bind = [&](std::size_t k) {
      const Tree& of = (*rule)["data"].at(1 + k);
      return t_.own(m_.type_of(of.at(1).row()), now_.at(of.at(1).row())).self(of.at(2).row());
    };
    guard.push_back(t_.holds((*rule)["guard"], v, t_.truth(true), state_fault_));
    z3::expr above = t_.truth(false);
    for (const Candidate& c : all_) above = either(above, both(c.possible, matches(*rule, true, c)));
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

// `down`s from the outside in, then the ports in the order of parameters.
void System::fire(const Candidate& candidate, std::size_t connector, Store& store, Step& step) {
  const Connector& c = m_.connectors[connector];
  for (const Clause& clause : m_.connector_types[c.type].clauses) {
    if (clause.down->items.empty()) continue;
    t_.execute(*clause.down, variables(connector, candidate.chosen, store), clause_is(c, clause, candidate.chosen), step.trouble.fault);
  }
  const auto part = [&](std::size_t chosen, std::size_t row) {
    // A port may be chosen below another alternative.
    const z3::expr when = both(candidate.chosen.at(c.root), candidate.chosen.at(chosen));
    if (is(when, false)) return;
    if (m_.nodes[row].connector != kNone) return fire(candidate, m_.nodes[row].connector, store, step);
    const std::size_t atom = m_.atom_of_port.at(row);
    Local& local = local_of(atom, store);
    t_.fire(m_.type_of(atom), offers_[atom], row - m_.first_port[atom], local, when, step.trouble);
    step.next.insert_or_assign(atom, local);
  };
  for (const Edge& edge : c.params) {
    if (m_.nodes[edge.node].kind != Kind::Any) part(edge.node, edge.node);
    else for (const Edge& one : m_.nodes[edge.node].children) part(one.node, m_.nodes[one.node].children[0].node);
  }
}

void System::each_step(const std::function<void(const Step&)>& visit) {
  find_candidates();
  for (const Candidate& c : all_) {
    if (is(c.possible, false)) continue;
    Step step{c.possible, c.offered, Trouble(c.possible.ctx()), {}};
    Store store = c.store;
    fire(c, c.connector, store, step);
    visit(step);
  }
  for (std::size_t port = 0; port < on_.size(); ++port) {
    if (!m_.nodes[port].is_step || is(on_[port], false)) continue;
    const std::size_t atom = m_.atom_of_port[port];
    Step step{on_[port], on_[port], Trouble(on_[port].ctx()), {{atom, now_[atom]}}};
    t_.fire(m_.type_of(atom), offers_[atom], port - m_.first_port[atom], step.next.at(atom), t_.truth(true), step.trouble);
    visit(step);
  }
}

z3::expr System::claim(const Tree& e) {
  Variables v;
  v.about = [this](const Tree& about) {
    const std::string_view path = about.at(1).text, what = about.head();
    for (std::size_t c = 0; what == "can" && c < m_.connectors.size(); ++c) {
      if (m_.connectors[c].path != path) continue;
      find_candidates();
      z3::expr some = t_.truth(false);
      for (const Candidate& candidate : all_) some = candidate.connector == c ? either(some, candidate.possible) : some;
      return some;
    }
    for (std::size_t a = 0; what != "can" && a < m_.atoms.size(); ++a) {
      if (m_.atoms[a].path != path) continue;
      const AtomType& type = m_.type_of(a);
      const std::vector<std::string_view>& names = what == "at" ? type.places : what == "data" ? type.slots : type.ports;
      const auto row = static_cast<std::size_t>(std::find(names.begin(), names.end(), about.at(2).text) - names.begin());
      if (row == names.size()) break;
      if (what == "data") return t_.own(type, now_[a]).self(row);
      return what == "at" ? now_[a].marks[row] : on_[m_.first_port[a] + row];
    }
    throw Rejected("the claim names something of `" + std::string(path) + "` that there is not");
  };
  z3::expr fault = t_.truth(false);
  return t_.evaluate(e, v, t_.truth(true), fault);
}

}  // namespace certcheck
