// Candidates, what priorities hide, and what a step does.
#include "tools/certcheck/system.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>

namespace certcheck {

System::System(const Model& model, const Terms& terms, const State& now)
    : m_(model), t_(terms), now_(now), state_fault_(terms.truth(false)), guard_fault_(state_fault_) {
  for (std::size_t atom = 0; atom < now_.size(); ++atom) {
    offers_.push_back(t_.offer(m_.type_of(atom), now_[atom], state_fault_));
    on_.insert(on_.end(), offers_[atom].ports.begin(), offers_[atom].ports.end());
  }
}

bool System::add_candidates(std::size_t connector, Want want) {
  const std::size_t root = m_.connectors[connector].root;
  const Rows tree = tree_of(root);
  if (is_plain(tree)) {
    Candidate c{connector, largest(tree, root), {}, t_.truth(false)};
    c.possible = enabled(tree, root, nullptr, c.chosen, c.store);
    all_.push_back(std::move(c));
    return true;
  }
  if (is_shared(tree) && !has_free_choices(tree)) throw NotCheckable("`" + std::string(m_.connectors[connector].path) + "` reaches a port in two ways");
  std::vector<Leaves> all;
  if (!list(root, want, all)) return false;
  std::vector<z3::expr> on;
  const std::size_t first = all_.size();
  for (const Leaves& leaves : all) {
    Candidate c{connector, fixed(tree, leaves), {}, t_.truth(false)};
    on.push_back(enabled(tree, root, &leaves, c.chosen, c.store));
    all_.push_back(std::move(c));
  }
  // Maximal progress: nothing larger is enabled.
  for (std::size_t k = 0; k < all.size(); ++k) {
    z3::expr& possible = all_[first + k].possible = on[k];
    for (std::size_t j = 0; j < all.size() && want == Want::All; ++j) {
      if (all[j].size() > all[k].size() && std::includes(all[j].begin(), all[j].end(), all[k].begin(), all[k].end())) possible = both(possible, no(on[j]));
    }
  }
  return true;
}

z3::expr System::has_step() {
  z3::expr_vector some(on_.empty() ? state_fault_.ctx() : on_[0].ctx());
  for (std::size_t port = 0; port < on_.size(); ++port) {
    if (m_.nodes[port].is_step) some.push_back(on_[port]);
  }
  for (std::size_t c = 0; c < m_.connectors.size(); ++c) {
    if (!m_.nodes[m_.connectors[c].root].is_step) continue;
    if (!add_candidates(c, Want::All)) (void)add_candidates(c, Want::Smallest);
    for (const Candidate& candidate : all_) some.push_back(candidate.possible);
    all_.clear();
  }
  is_complete_ = false;
  return z3::mk_or(some);
}

void System::find_candidates() {
  if (is_complete_) return;
  is_complete_ = true;
  for (std::size_t c = 0; c < m_.connectors.size(); ++c) {
    if (m_.nodes[m_.connectors[c].root].is_step && !add_candidates(c, Want::All)) throw NotCheckable("a connector has too many interactions");
  }
  if (!m_.priorities.empty()) hide();
}

z3::expr System::matches(const Tree& rule, const char* side, const Candidate& c) const {
  const bool high = std::string_view(side) == "high";
  const Tree& pattern = *rule.find(side);
  const Tree& other = *rule.find(high ? "low" : "high");
  if (pattern.items.at(1).text == "any") {
    if (m_.connectors[c.connector].compound != rule.find("in")->items.at(1).row()) return t_.truth(false);
    return other.items.at(1).text == "any" ? t_.truth(true) : no(matches(rule, high ? "low" : "high", c));
  }
  if (pattern.items[1].row() != c.connector) return t_.truth(false);
  if (pattern.items.at(2).text == "any") return t_.truth(true);
  std::set<std::size_t> named;
  for (std::size_t k = 2; k < pattern.items.size(); ++k) named.insert(pattern.items[k].row());
  z3::expr result = t_.truth(true);
  const std::vector<Edge>& params = m_.connectors[c.connector].params;
  for (std::size_t p = 0; p < params.size(); ++p) {
    const z3::expr& part = c.chosen.at(params[p].node);
    if (high && named.contains(p)) result = both(result, part);
    if (!high && !named.contains(p)) result = both(result, no(part));
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
      const Tree& of = rule->find("data")->items.at(1 + k);
      const std::size_t atom = of.items.at(1).row();
      return t_.own(m_.type_of(atom), now_.at(atom)).self(of.items.at(2).row());
    };
    const Tree* condition = rule->find("guard");
    guard.push_back(condition == nullptr ? t_.truth(true) : t_.evaluate(condition->items.at(1), v, t_.truth(true), state_fault_));
    z3::expr above = t_.truth(false);
    for (const Candidate& c : all_) above = either(above, both(c.possible, matches(*rule, "high", c)));
    hides.push_back(both(guard.back(), above));
  }
  for (std::size_t round = 0; round < count; ++round) {
    std::vector<z3::expr> next = hides;
    for (std::size_t r = 0; r < count; ++r) {
      for (std::size_t s = 0; s < count; ++s) {
        const bool meet = r != s && std::any_of(all_.begin(), all_.end(), [&](const Candidate& c) {
          return is(matches(*m_.priorities[r], "high", c), true) && is(matches(*m_.priorities[s], "low", c), true);
        });
        if (meet) next[r] = either(next[r], both(guard[r], hides[s]));
      }
    }
    hides = next;
  }
  for (Candidate& c : all_) {
    for (std::size_t r = 0; r < count; ++r) c.possible = both(c.possible, no(both(hides[r], matches(*m_.priorities[r], "low", c))));
  }
}

// `down`s from the outside in, then the ports in the order of parameters.
void System::fire(const Candidate& candidate, std::size_t connector, Store& store, Step& step) {
  const Connector& c = m_.connectors[connector];
  for (const Tree& clause : c.type->items) {
    if (clause.head() == "clause") t_.execute(clause.find("down"), 1, variables(connector, candidate.chosen, store), clause_is(c, clause, candidate.chosen), step.trouble.fault);
  }
  Rows parts;
  for (const Edge& edge : c.params) {
    if (m_.nodes[edge.node].kind != Kind::Any) parts.push_back(edge.node);
    else std::transform(m_.nodes[edge.node].children.begin(), m_.nodes[edge.node].children.end(), std::back_inserter(parts), [](const Edge& one) { return one.node; });
  }
  for (std::size_t row : parts) {
    // A port may be chosen below another alternative.
    const z3::expr when = both(candidate.chosen.at(c.root), candidate.chosen.at(row));
    if (is(when, false)) continue;
    if (m_.nodes[row].connector != kNone) {
      fire(candidate, m_.nodes[row].connector, store, step);
      continue;
    }
    const std::size_t atom = m_.atom_of_port.at(row);
    Local& local = local_of(atom, store);
    t_.fire(m_.type_of(atom), offers_[atom], row - m_.first_port[atom], local, when, step.trouble);
    step.next.insert_or_assign(atom, local);
  }
}

void System::each_step(const std::function<void(const Step&)>& visit) {
  find_candidates();
  for (const Candidate& c : all_) {
    if (is(c.possible, false)) continue;
    Step step{c.possible, Trouble(c.possible.ctx()), {}};
    Store store = c.store;
    fire(c, c.connector, store, step);
    visit(step);
  }
  for (std::size_t port = 0; port < on_.size(); ++port) {
    if (!m_.nodes[port].is_step || is(on_[port], false)) continue;
    const std::size_t atom = m_.atom_of_port[port];
    Step step{on_[port], Trouble(on_[port].ctx()), {}};
    Local local = now_[atom];
    t_.fire(m_.type_of(atom), offers_[atom], port - m_.first_port[atom], local, t_.truth(true), step.trouble);
    step.next.emplace(atom, local);
    visit(step);
  }
}

z3::expr System::claim(const Tree& e) {
  Variables v;
  v.about = [this](const Tree& about) {
    const std::string& path = about.items.at(1).text;
    for (std::size_t c = 0; about.head() == "can" && c < m_.connectors.size(); ++c) {
      if (m_.connectors[c].path != path) continue;
      find_candidates();
      z3::expr some = t_.truth(false);
      for (const Candidate& candidate : all_) some = candidate.connector == c ? either(some, candidate.possible) : some;
      return some;
    }
    for (std::size_t a = 0; about.head() != "can" && a < m_.atoms.size(); ++a) {
      if (m_.atoms[a].path != path) continue;
      const AtomType& type = m_.type_of(a);
      const std::vector<std::string>& names = about.head() == "at" ? type.places : about.head() == "data" ? type.slots : type.ports;
      const auto found = std::find(names.begin(), names.end(), about.items.at(2).text);
      if (found == names.end()) break;
      const std::size_t row = static_cast<std::size_t>(found - names.begin());
      if (about.head() == "data") return t_.own(type, now_[a]).self(row);
      return about.head() == "at" ? now_[a].marks[row] : on_[m_.first_port[a] + row];
    }
    throw Rejected("the claim names something of `" + path + "` that there is not");
  };
  z3::expr fault = t_.truth(false);
  return t_.evaluate(e, v, t_.truth(true), fault);
}

}  // namespace certcheck
