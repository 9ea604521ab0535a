// The states that the rows allow: the first one is among them, every step stays among them, and none of them is bad. All at once, as
// terms with the rows as facts; or those of a diagram, one by one, with all terms constants, for which no solver is needed.
#include <algorithm>

#include "tools/certcheck/check.hpp"
#include "tools/certcheck/system.hpp"

namespace certcheck {

namespace {

constexpr unsigned kFew = 8;

class States {
 public:
  States(const Model& model, const Certificate& certificate) : m_(model), c_(certificate), terms_(model, z_), system_(model, terms_) {
    if (c_.claim == "deadlock-free" || c_.claim == "error-free") return;
    claim_ = read_trees(c_.claim);
    if (claim_.items.size() != 2 || claim_.items[0].text != "never") throw Rejected("the claim `" + c_.claim + "`");
  }

  void all() {
    State now;
    assume_modes(now);
    if (c_.is_induction) {
      Trouble begin(z_);
      const State first = begin_with(begin);
      for (const Fact& fact : c_.facts) demand(both(no(begin.fault), no(holds(fact, first))), fact.text + ": does not hold at first");
    }
    for (const Fact& fact : c_.facts) terms_.assume(holds(fact, now), fact.literals.size() == 1 ? fact.literals[0].atom : kNone);
    check_from(now, [&](const Step& step) {
      z3::expr broken = terms_.truth(false);
      for (const Fact& fact : c_.facts) {
        const auto changes = [&](const Literal& l) { return !z3::eq(term(l, now, nullptr), term(l, now, &step)); };
        if (std::any_of(fact.literals.begin(), fact.literals.end(), changes)) broken = either(broken, no(holds(fact, now, &step)));
      }
      return broken;
    });
  }

  std::string one_by_one() {
    const std::set<Values> states = reached_states(m_, c_);
    Trouble begin(z_);
    const State first = begin_with(begin);
    demand(both(no(begin.fault), terms_.truth(!states.contains(values(first)))), "the first state is not among those that are listed");
    if (c_.claim == "error-free") demand(begin.fault, "the run ends before its first state");
    for (const Values& one : states) {
      State now;
      auto value = one.begin();
      for (const Atom& atom : m_.atoms) {
        const AtomType& type = m_.atom_types[atom.type];
        const auto values_of = value + static_cast<long>(type.places.size());
        now.push_back(terms_.local(atom, [&](std::size_t p) { return terms_.truth(value[static_cast<long>(p)] != 0); },
                                   [&](std::size_t k) { return terms_.constant(type.types[k], values_of[static_cast<long>(k)]); }));
        value = values_of + static_cast<long>(type.slots.size());
      }
      check_from(now, [&](const Step& step) {
        State after = now;
        for (const auto& [atom, local] : step.next) after[atom] = local;
        return terms_.truth(!states.contains(values(after)));
      });
    }
    return std::to_string(states.size());
  }

 private:
  // There is no state like that.
  void demand(const z3::expr& bad, const std::string& otherwise) {
    if (terms_.may_be(bad)) throw Rejected(otherwise);
  }

  State begin_with(Trouble& begin) {
    State first;
    for (const Atom& atom : m_.atoms) first.push_back(terms_.initial(atom, begin));
    if (!is(begin.lost, false)) throw NotCheckable("internal transitions at the beginning go on for too long");
    return first;
  }

  // Of these states, which a step must not leave, none is bad. Where the run has ended with an error nothing follows.
  void check_from(const State& now, const std::function<z3::expr(const Step&)>& leaves) {
    system_.look_at(now);
    if (c_.is_induction) system_.find_candidates();
    if (c_.claim == "error-free") demand(either(system_.state_fault(), system_.guard_fault()), "a state that the certificate allows ends with an error");
    if (is(system_.state_fault(), true)) return;
    if (c_.reached == kNone) terms_.assume(no(system_.state_fault()));
    else if (!is(system_.state_fault(), false)) throw NotCheckable("what a state does depends on values that are not followed");
    bool has_step = false;  // for sure
    if (c_.is_induction) {
      system_.each_step([&](const Step& step) {
        has_step = has_step || is(step.possible, true);
        // First without what priorities hide, and only for the atoms that move.
        const auto can = [&](const z3::expr& e) { return terms_.may_be_alone(both(step.offered, e), step.next) && terms_.may_be(both(step.possible, e)); };
        if (can(step.trouble.lost)) throw NotCheckable("internal transitions go on for too long to be followed");
        if (c_.claim == "error-free" && can(step.trouble.fault)) throw Rejected("a step ends with an error");
        const z3::expr goes_on = no(step.trouble.fault);
        if (is(both(step.possible, goes_on), false)) return;
        if (can(both(goes_on, leaves(step)))) throw Rejected("a step leads out of what the certificate allows");
      });
    }
    if (c_.claim == "deadlock-free" && !has_step) demand(no(system_.has_step()), "a state that the certificate allows has no step");
    if (!claim_.items.empty()) demand(system_.claim(claim_.items[1]), "a state that the certificate allows is what should never be");
  }

  [[nodiscard]] Values values(const State& state) const {
    Values all;
    const auto add = [&](const z3::expr& e, bool is_param) {
      const std::optional<int> value = Terms::value(e.simplify());
      if (!value && !is_param) throw NotCheckable("a value is not followed");
      all.push_back(value.value_or(0));
    };
    for (std::size_t a = 0; a < state.size(); ++a) {
      for (const z3::expr& mark : state[a].marks) add(mark, false);
      for (std::size_t k = 0; k < state[a].slots.size(); ++k) add(state[a].slots[k], m_.type_of(a).is_param[k]);
    }
    return all;
  }

  // What it speaks of, in a state or after a step from there.
  [[nodiscard]] static z3::expr term(const Literal& l, const State& state, const Step* step) {
    const Local& local = step != nullptr && step->next.contains(l.atom) ? step->next.at(l.atom) : state[l.atom];
    return l.about == Literal::Place ? local.marks[l.row] : local.slots[l.row];
  }
  [[nodiscard]] z3::expr holds(const Literal& l, const State& state, const Step* step) const {
    const z3::expr v = term(l, state, step);
    z3::expr result = v;
    if (l.about == Literal::Bit && !v.is_bool()) result = v.extract(static_cast<unsigned>(l.low), static_cast<unsigned>(l.low)) == z3::expr(v.ctx().bv_val(1, 1));
    if (l.about == Literal::Value) result = v.is_bool() ? v == terms_.truth(l.low != 0) : v == terms_.constant("int", l.low);
    if (l.about == Literal::Range && v.is_bool()) result = (terms_.truth(l.low <= 0) || v) && (terms_.truth(l.high >= 1) || !v);
    if (l.about == Literal::Range && !v.is_bool()) result = v >= terms_.constant("int", l.low) && v <= terms_.constant("int", l.high);
    return (l.is_negated ? !result : result).simplify();
  }
  [[nodiscard]] z3::expr holds(const Fact& fact, const State& state, const Step* step = nullptr) const {
    z3::expr some = terms_.truth(false);
    for (const Literal& literal : fact.literals) some = either(some, holds(literal, state, step));
    return some;
  }

  // Their weights add up to the total. Few of which one holds are told by clauses, which the solver likes best.
  void assume_sum(const z3::expr_vector& all, const std::vector<int>& weights, int total, std::size_t atom) {
    const bool is_one = total == 1 && std::count(weights.begin(), weights.end(), 1) == static_cast<long>(weights.size());
    if (all.empty()) return terms_.assume(terms_.truth(total == 0), atom);
    if (!is_one || all.size() > kFew) return terms_.assume(z3::pbeq(all, weights.data(), total), atom);
    terms_.assume(z3::mk_or(all), atom);
    for (unsigned k = 0; k < all.size(); ++k) {
      for (unsigned j = 0; j < k; ++j) terms_.assume(!all[j] || !all[k], atom);
    }
  }
  void exactly_one(const z3::expr_vector& all, std::size_t atom) { assume_sum(all, std::vector<int>(all.size(), 1), 1, atom); }

  // What has been found to hold: a mode for each atom, which says where it is; the sets.
  void assume_modes(State& now) {
    std::vector<std::map<std::size_t, z3::expr>> modes(m_.atoms.size());
    for (std::size_t a = 0; a < m_.atoms.size(); ++a) {
      const AtomType& type = m_.type_of(a);
      const auto unknown = [&](std::size_t) { return c_.classes.empty() ? terms_.fresh("bool") : terms_.truth(false); };
      z3::expr_vector all(z_);
      now.push_back(terms_.local(m_.atoms[a], unknown, [&](std::size_t k) { return terms_.fresh(type.types[k]); }));
      if (c_.classes.empty()) {
        for (const z3::expr& mark : now[a].marks) all.push_back(mark);
        if (type.is_automaton) exactly_one(all, a);
        continue;
      }
      const Class& row = c_.classes[c_.class_of[a]];
      for (std::size_t number : c_.reachable[a]) {
        const bool is_other = c_.reachable[a].size() == 2 && all.size() == 1;
        const z3::expr mode = modes[a].emplace(number, is_other ? !all[0] : terms_.fresh("bool")).first->second;
        all.push_back(mode);
        for (std::size_t place : row.modes[number].places) now[a].marks[place] = either(now[a].marks[place], mode);
        terms_.assume(either(no(mode), terms_.has_values(type, now[a], row.modes[number].values)), a);
      }
      if (all.size() != 2) exactly_one(all, a);
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
  }

  const Model& m_;
  const Certificate& c_;
  z3::context z_;
  Terms terms_;
  System system_;
  Tree claim_;
};

}  // namespace

std::string check(const Model& model, const std::string& text) {
  const Certificate c = read_certificate(model, text);
  const std::string components = std::to_string(model.atoms.size()) + " components, ";
  if (c.reached != kNone) return components + States(model, c).one_by_one() + " states";
  if (!c.classes.empty()) check_structure(model, c);
  States(model, c).all();
  const auto count = [](std::size_t number, const std::string& what) { return std::to_string(number) + " " + what + (number == 1 ? "" : "s"); };
  return components + count(c.sets.size(), "invariant") + (c.is_induction ? ", " + count(c.facts.size(), "fact") : "");
}

}  // namespace certcheck
