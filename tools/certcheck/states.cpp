// The states that the rows allow: the first one is among them, every step stays among them, and none of them is bad. All at once, as
// terms with the rows as facts; or those of a diagram, one by one, with all terms constants, for which no solver is needed.
#include "tools/certcheck/system.hpp"

namespace certcheck {
namespace {

class States {
 public:
  States(const Model& model, const Certificate& certificate) : m_(model), c_(certificate), terms_(model, z_), system_(model, terms_) {
    if (c_.claim == "deadlock-free" || c_.claim == "error-free") return;
    claim_ = read_trees(c_.claim);
    if (claim_.items.size() != 2 || claim_.items[0].text != "never") throw Rejected("the claim " + quoted(c_.claim));
  }

  void all() {
    if (c_.is_induction) {
      expr fault = terms_.truth(false);
      const State first = begin(fault);
      for (const Fact& fact : c_.facts) demand(both(no(fault), no(holds(fact, first))), fact.line + ": does not hold at first");
      for (const Equation& one : c_.equations) demand(both(no(fault), no(equals(sum(one, first), one.total))), one.line + ": does not hold at first");
    }
    State now = allowed();
    // Between steps no internal transition is left.
    for (std::size_t a = 0; a < now.size(); ++a) terms_.assume(no(terms_.goes_on(m_.type_of(a), now[a])), a);
    for (const Equation& one : c_.equations) terms_.assume(equals(sum(one, now), one.total));
    for (const Fact& fact : c_.facts) terms_.assume(holds(fact, now), fact.literals.size() == 1 ? fact.literals[0].atom : kNone);
    check_from(now, [&](const Step& step) {
      const auto changes = [&](const Literal& l) { return !z3::eq(term(l, now, nullptr), term(l, now, &step)); };
      const expr lost = terms_.some(c_.facts, [&](const Fact& fact) {
        return std::any_of(fact.literals.begin(), fact.literals.end(), changes) ? no(holds(fact, now, &step)) : terms_.truth(false);
      });
      return either(lost, terms_.some(c_.equations, [&](const Equation& one) { return no(equals(sum(one, now, &step), 0)); }));
    });
  }

  std::string one_by_one() {
    State any;
    for (const Atom& atom : m_.atoms) any.push_back(terms_.local(atom, [&](std::size_t) { return terms_.fresh("float"); }));
    list(c_.reached, values(any, false), 0);
    expr fault = terms_.truth(false);
    const State first = begin(fault);
    demand(both(no(fault), terms_.truth(!states_.contains(values(first)))), "the first state is not among those that are listed");
    for (const std::vector<Values>& one : states_) {
      State now;
      for (const Atom& atom : m_.atoms) {
        const std::vector<Variable>& variables = m_.atom_types[atom.type].variables;
        const Values& values = one[now.size()];
        now.push_back(terms_.local(atom, [&](std::size_t k) { return terms_.constant(variables[k].type, *values[k]); }));
      }
      check_from(now, [&](const Step& step) {
        State after = now;
        for (const auto& [atom, local] : step.next) after[atom] = local;
        return terms_.truth(!states_.contains(values(after)));
      });
    }
    return std::to_string(states_.size());
  }

 private:
  // There is no state like that.
  void demand(const expr& bad, const std::string& otherwise) {
    if (terms_.may_be(bad)) throw Rejected(otherwise);
  }
  State begin(expr& fault) {
    State first;
    for (const Atom& atom : m_.atoms) first.push_back(terms_.initial(atom, fault));
    if (c_.claim == "error-free") demand(fault, "the run ends before its first state");
    return first;
  }
  // Of these states, which a step must not leave, none is bad. Where the run has ended with an error nothing follows.
  void check_from(const State& now, const std::function<expr(const Step&)>& leaves) {
    const bool no_errors = c_.claim == "error-free";
    system_.look_at(now, c_.is_induction);
    if (no_errors) demand(either(system_.state_fault(), system_.guard_fault()), "a state that the certificate allows ends with an error");
    if (is(system_.state_fault(), true)) return;
    if (c_.reached == kNone) terms_.assume(no(system_.state_fault()));
    else if (!is(system_.state_fault(), false)) throw NotCheckable("what a state does depends on values that are not followed");
    if (c_.is_induction) {
      system_.each_step([&](const Step& step) {
        // First without what priorities hide, and only for the atoms that move.
        const auto can = [&](const expr& e) { return terms_.may_be(both(step.offered, e), &step.next) && terms_.may_be(both(step.possible, e)); };
        if (no_errors && can(step.fault)) throw Rejected("a step ends with an error");
        const expr goes_on = no(step.fault);
        if (is(both(step.possible, goes_on), false)) return;
        if (can(both(goes_on, leaves(step)))) throw Rejected("a step leads out of what the certificate allows");
      });
    }
    if (c_.claim == "deadlock-free") demand(no(system_.has_step()), "a state that the certificate allows has no step");
    if (!claim_.items.empty()) demand(system_.claim(claim_.items[1]), "a state that the certificate allows is what should never be");
  }
  // The states of a diagram, by all ways through it, each of which must say everything. Cost: the states times what is in one.
  void list(std::size_t node, const std::vector<Values>& before, int depth) {
    constexpr int kMaxDepth = 10000;
    constexpr std::size_t kMaxStates = 5000000;
    if (depth > kMaxDepth || states_.size() > kMaxStates) throw NotCheckable("the diagram is too large");
    for (const Case& one : c_.nodes[node]) {
      std::vector<Values> known = before;
      bool is_way = true;  // nothing has two values on it
      const auto say = [&](std::size_t atom, std::size_t variable, int value) {
        is_way = is_way && known[atom][variable].value_or(value) == value;
        known[atom][variable] = value;
      };
      for (const Literal& l : one.literals) {
        const AtomType& type = m_.type_of(l.atom);
        const bool is_place = l.variable < type.places;
        if (l.bit || (l.is_negated && !is_place)) throw Rejected("a case is of places and values");
        for (std::size_t p = 0; p < type.places && is_place && type.is_automaton && !l.is_negated; ++p) say(l.atom, p, p == l.variable ? 1 : 0);
        say(l.atom, l.variable, l.is_negated ? 0 : l.low);
      }
      if (is_way && one.next != kNone) list(one.next, known, depth + 1);
      if (!is_way || one.next != kNone) continue;
      for (std::size_t a = 0; a < known.size(); ++a) {
        if (contains(known[a], std::nullopt)) throw Rejected("a case leaves something of " + quoted(m_.atoms[a].path) + " open");
      }
      states_.insert(std::move(known));
    }
  }
  // Parameters are what the system says, whatever that is.
  [[nodiscard]] std::vector<Values> values(const State& state, bool needs_all = true) const {
    std::vector<Values> all;
    for (const Local& local : state) {
      const AtomType& type = m_.type_of(all.size());
      Values& values = all.emplace_back();
      for (std::size_t k = 0; k < local.size(); ++k) {
        values.push_back(value_of(local[k].simplify()));
        if (!values[k] && type.variables[k].is_param) values[k] = 0;
        if (!values[k] && needs_all) throw NotCheckable("a value is not followed");
      }
    }
    return all;
  }
  // What it speaks of, in a state or after a step from there.
  [[nodiscard]] static const expr& term(const Literal& l, const State& state, const Step* step) {
    return (step != nullptr && step->next.contains(l.atom) ? step->next.at(l.atom) : state[l.atom])[l.variable];
  }
  [[nodiscard]] expr holds(const Fact& fact, const State& state, const Step* step = nullptr) const {
    return terms_.some(fact.literals, [&](const Literal& l) {
      const expr& v = term(l, state, step);
      const auto within = [&](int value) { return terms_.truth(l.low <= value && value <= l.high); };
      expr result = v;
      if (v.is_bool()) result = either(both(within(1), v), both(within(0), no(v)));
      else if (l.bit) result = equals(v.extract(*l.bit, *l.bit).simplify(), 1);
      else result = l.low == l.high ? equals(v, l.low) : (v >= l.low && v <= l.high).simplify();
      return l.is_negated ? no(result) : result;
    });
  }
  // What an equation says never changes; of a step, by how much it does.
  [[nodiscard]] expr sum(const Equation& equation, const State& state, const Step* step = nullptr) const {
    expr result = terms_.constant("int", 0);
    for (const auto& [of, weight] : equation.terms) {
      const expr times = terms_.constant("int", weight);
      const auto product = [&](const expr& e) { return e.is_bool() ? choose(e, times, terms_.constant("int", 0)) : times * e; };
      if (step == nullptr || step->next.contains(of.atom)) result = result + product(term(of, state, step));
      if (step != nullptr && step->next.contains(of.atom)) result = result - product(term(of, state, nullptr));
    }
    return result.simplify();
  }
  // Their weights add up to the total. Few of which one holds are told by clauses, which the solver likes best.
  void assume_sum(const z3::expr_vector& all, const std::vector<int>& weights, int total, std::size_t atom) {
    constexpr unsigned kFew = 8;
    const bool is_one = total == 1 && std::count(weights.begin(), weights.end(), 1) == static_cast<long>(weights.size());
    if (all.empty()) return terms_.assume(terms_.truth(total == 0), atom);
    if (!is_one || all.size() > kFew) return terms_.assume(z3::pbeq(all, weights.data(), total), atom);
    terms_.assume(z3::mk_or(all), atom);
    for (unsigned k = 0; k < all.size(); ++k) for (unsigned j = 0; j < k; ++j) terms_.assume(!all[j] || !all[k], atom);
  }
  // All states of which what has been found holds: a mode for each atom, which says where it is; the sets.
  State allowed() {
    State now;
    const bool has_modes = !c_.classes.empty();
    std::vector<std::map<std::size_t, expr>> modes(m_.atoms.size());
    for (std::size_t a = 0; a < m_.atoms.size(); ++a) {
      const AtomType& type = m_.type_of(a);
      // What is the same in all modes is known.
      Values same(type.variables.size());
      const auto values_of = [&](std::size_t number) -> const Values& { return c_.classes[c_.class_of[a]].modes[number]; };
      if (!c_.reachable[a].empty()) same = values_of(*c_.reachable[a].begin());
      for (std::size_t number : c_.reachable[a])
        for (std::size_t k = 0; k < same.size(); ++k) same[k] = same[k] == values_of(number)[k] ? same[k] : std::nullopt;
      const auto unknown = [&](std::size_t k) {
        if (has_modes && k < type.places) return terms_.truth(false);
        return same[k] ? terms_.constant(type.variables[k].type, *same[k]) : terms_.fresh(type.variables[k].type);
      };
      Local& local = now.emplace_back(terms_.local(m_.atoms[a], unknown));
      z3::expr_vector all(z_);
      for (std::size_t p = 0; p < type.places && !has_modes && type.is_automaton; ++p) all.push_back(local[p]);
      for (std::size_t number : c_.reachable[a]) {
        const Values& values = values_of(number);
        const bool is_other = c_.reachable[a].size() == 2 && all.size() == 1;
        const expr mode = modes[a].emplace(number, is_other ? !all[0] : terms_.fresh("bool")).first->second;
        all.push_back(mode);
        for (std::size_t p = 0; p < type.places; ++p) local[p] = *values[p] != 0 ? either(local[p], mode) : local[p];
        terms_.assume(either(no(mode), terms_.has(local, values, type.places)), a);
      }
      if (has_modes ? all.size() != 2 : type.is_automaton) assume_sum(all, std::vector<int>(all.size(), 1), 1, a);
    }
    for (const Set& set : c_.sets) {
      z3::expr_vector members(z_);
      std::vector<int> weights;
      for (const auto& [member, weight] : set.weights) {
        const auto found = modes[member.first].find(member.second);
        if (found == modes[member.first].end()) continue;
        members.push_back(found->second);
        weights.push_back(weight);
      }
      if (set.is_trap) terms_.assume(z3::mk_or(members));
      else assume_sum(members, weights, set.total, kNone);
    }
    return now;
  }

  const Model& m_;
  const Certificate& c_;
  z3::context z_;
  Terms terms_;
  System system_;
  Tree claim_;
  std::set<std::vector<Values>> states_;  // of a diagram, by atom
};

}  // namespace

std::string check(const Model& model, const std::string& text) {
  const Certificate c = read_certificate(model, text);
  const std::string components = std::to_string(model.atoms.size()) + " components, ";
  if (c.reached != kNone) return components + States(model, c).one_by_one() + " states";
  if (!c.classes.empty()) check_structure(model, c);
  States(model, c).all();
  const auto count = [](std::size_t number, const std::string& what) { return std::to_string(number) + " " + what + (number == 1 ? "" : "s"); };
  return components + count(c.sets.size(), "invariant") + (c.is_induction ? ", " + count(c.facts.size() + c.equations.size(), "fact") : "");
}

}  // namespace certcheck
