// Ranges and lemmas: true at first, kept by every step from a state that satisfies everything, and such a state is not bad.
#include <algorithm>

#include "tools/certcheck/induction.hpp"
#include "tools/certcheck/symbolic.hpp"

namespace certcheck {

z3::expr satisfied(const Set& set, z3::context& z, const std::vector<std::map<std::size_t, z3::expr>>& modes) {
  z3::expr_vector all(z);
  std::vector<int> weights;
  for (std::size_t k = 0; k < set.members.size(); ++k) {
    const auto& [atom, state] = set.members[k];
    const auto found = modes[atom].find(state);
    if (found == modes[atom].end()) continue;
    all.push_back(found->second);
    weights.push_back(set.weights[k]);
  }
  if (all.empty()) return z.bool_val(!set.is_trap && set.total == 0);
  return set.is_trap ? z3::mk_or(all) : z3::pbeq(all, weights.data(), set.total);
}

namespace {

class Induction {
 public:
  Induction(const Model& model, const Certificate& certificate) : m_(model), c_(certificate), s_(model, z_), solver_(z_) {}

  void run() {
    z3::expr fault = s_.truth(false);
    const State first = s_.initial_state(fault);
    for (std::size_t k = 0; k < c_.facts.size(); ++k) {
      demand(!fault && !holds(c_.facts[k], first), c_.facts[k].text + ": does not hold at first");
    }
    now_ = s_.any_state("s");
    assume_places();
    if (!c_.classes.empty()) assume_structure();
    for (const Fact& fact : c_.facts) solver_.add(holds(fact, now_));
    s_.look(now_);
    const std::vector<Step> steps = s_.steps();
    z3::expr_vector possible(z_);
    for (const Step& step : steps) {
      possible.push_back(step.possible);
      check_step(step);
    }
    if (c_.claim == "deadlock-free") {
      demand(!s_.state_fault() && !z3::mk_or(possible), "a state that satisfies all rows has no step");
    } else if (c_.claim == "error-free") {
      demand(s_.state_fault() || s_.guard_fault(), "a state that satisfies all rows ends with an error");
    } else {
      const std::vector<Tree> claim = read_trees(c_.claim);
      if (claim.size() != 2 || claim[0].text != "never") throw Rejected("the claim `" + c_.claim + "`");
      demand(!s_.state_fault() && s_.evaluate(claim[1], {}, s_.truth(true), fault), "a state that satisfies all rows is what should never be");
    }
  }

 private:
  // There is no state like that.
  void demand(const z3::expr& bad, const std::string& otherwise) {
    const z3::expr simple = bad.simplify();
    if (simple.is_false()) return;
    solver_.push();
    solver_.add(simple);
    const z3::check_result answer = solver_.check();
    solver_.pop();
    if (answer == z3::sat) throw Rejected(otherwise);
    if (answer != z3::unsat) throw NotCheckable("the solver gives up");
  }

  z3::expr value(const Fact::Part& part, const State& state) { return state[part.atom].slots.at(part.row); }
  z3::expr literal(const Fact::Part& part, const State& state, const std::string& text) {
    z3::expr result = part.is_place ? state[part.atom].marks.at(part.row) : value(part, state);
    if (part.is_value) result = result.is_bool() ? (part.value != 0 ? result : !result) : result == z_.bv_val(part.value, 32);
    else if (!result.is_bool()) result = result.extract(part.bit, part.bit) == z_.bv_val(1, 1);
    else if (!part.is_place && part.bit != 0) throw Rejected(text + ": a bool has one bit");
    return part.is_negated ? !result : result;
  }
  z3::expr node_holds(std::size_t last, const State& state) {
    std::vector<z3::expr> nodes;
    for (std::size_t k = 0; k <= last; ++k) {
      z3::expr_vector cases(z_);
      for (const Case& one : c_.nodes[k]) {
        z3::expr_vector all(z_);
        for (const Fact::Part& part : one.parts) all.push_back(literal(part, state, "a case").simplify());
        if (!one.is_end) all.push_back(nodes.at(one.next));
        cases.push_back(z3::mk_and(all));
      }
      nodes.push_back(z3::mk_or(cases).simplify());
    }
    return nodes.back();
  }
  z3::expr holds(const Fact& fact, const State& state) {
    if (fact.is_reached) return node_holds(fact.node, state);
    if (fact.is_range) {
      const z3::expr v = value(fact.parts.at(0), state);
      if (v.is_bool()) return (fact.low <= 0 || v) && (fact.high >= 1 || !v) && s_.truth(fact.low <= 1 && fact.high >= 0);
      return (v >= z_.bv_val(fact.low, 32) && v <= z_.bv_val(fact.high, 32)).simplify();
    }
    z3::expr_vector some(z_);
    for (const Fact::Part& part : fact.parts) some.push_back(literal(part, state, fact.text));
    return z3::mk_or(some).simplify();
  }

  void check_step(const Step& step) {
    State after = now_;
    for (const auto& [atom, local] : step.next) after[atom] = local;
    const z3::expr taken = step.possible && !s_.state_fault();
    z3::expr_vector broken(z_);
    for (const Fact& fact : c_.facts) {
      const bool moves = fact.is_reached || std::any_of(fact.parts.begin(), fact.parts.end(), [&](const Fact::Part& part) { return step.next.contains(part.atom); });
      if (moves) broken.push_back(!holds(fact, after));
    }
    demand(taken && !step.fault && z3::mk_or(broken), "a step leads out of the lemmas");
    demand(taken && step.lost, "internal transitions go on for too long to be followed");
    if (c_.claim == "error-free") demand(taken && step.fault, "a step ends with an error");
  }

  // One place of an automaton is marked: its transitions take one token and put one.
  void assume_places() {
    for (std::size_t a = 0; a < m_.atoms.size(); ++a) {
      const AtomType& type = m_.atom_types[m_.atoms[a].type];
      const bool alone = type.initial.size() == 1 && std::all_of(type.transitions.begin(), type.transitions.end(), [](const Transition& t) { return t.from.size() == 1 && t.to.size() == 1; });
      if (!alone) continue;
      z3::expr_vector all(z_);
      for (const z3::expr& mark : now_[a].marks) all.push_back(mark);
      exactly_one(all);
    }
  }
  void exactly_one(const z3::expr_vector& all) {
    solver_.add(z3::mk_or(all));
    if (all.size() > 1) solver_.add(z3::atmost(all, 1));
  }

  // What the other checks have found to hold: a mode for each atom, the sets.
  void assume_structure() {
    std::vector<std::map<std::size_t, z3::expr>> modes(m_.atoms.size());
    for (std::size_t a = 0; a < m_.atoms.size(); ++a) {
      const Class& row = c_.classes[c_.class_of[a]];
      const AtomType& type = m_.atom_types[row.type];
      z3::expr_vector all(z_);
      for (std::size_t number : c_.reachable[a]) {
        const z3::expr mode = z_.bool_const(("m" + std::to_string(a) + ":" + std::to_string(number)).c_str());
        modes[a].emplace(number, mode);
        all.push_back(mode);
        const LocalState& state = row.states.at(number);
        z3::expr fits = s_.truth(true);
        for (std::size_t p = 0; p < type.places.size(); ++p) fits = fits && (state.places.contains(p) ? now_[a].marks[p] : !now_[a].marks[p]);
        for (std::size_t k = 0; k < type.slots.size(); ++k) {
          if (!state.values[k].is_known) continue;
          const z3::expr v = now_[a].slots[k];
          if (v.is_bool()) fits = fits && v == s_.truth(state.values[k].value != 0);
          else fits = fits && v == z_.bv_val(type.types[k] == "string" ? std::max(state.values[k].value, 0) : state.values[k].value, 32);
        }
        solver_.add(z3::implies(mode, fits.simplify()));
      }
      exactly_one(all);
    }
    for (const Set& set : c_.sets) {
      solver_.add(satisfied(set, z_, modes));
    }
  }

  const Model& m_;
  const Certificate& c_;
  z3::context z_;
  Symbolic s_;
  z3::solver solver_;
  State now_;
};

}  // namespace

void check_induction(const Model& model, const Certificate& certificate) { Induction(model, certificate).run(); }

}  // namespace certcheck
