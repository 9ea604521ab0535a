// All states that satisfy every row: true at first, kept by every step, and none of them is bad.
#include <algorithm>

#include "tools/certcheck/check.hpp"
#include "tools/certcheck/system.hpp"

namespace certcheck {

namespace {

class States {
 public:
  States(const Model& model, const Certificate& certificate) : m_(model), c_(certificate), terms_(model, z_), solver_(z_) {}

  void run() {
    State now, first;
    Trouble begin(z_);
    for (const Atom& atom : m_.atoms) now.push_back(terms_.any(atom));
    assume_modes(now);
    if (c_.is_induction) {
      for (const Atom& atom : m_.atoms) first.push_back(terms_.initial(atom, begin));
      if (!is(begin.lost, false)) throw NotCheckable("internal transitions at the beginning go on for too long");
    }
    for (const Fact& fact : c_.facts) demand(both(no(begin.fault), no(holds(fact, first))), fact.text + ": does not hold at first");
    for (const Fact& fact : c_.facts) solver_.add(holds(fact, now));
    System system(m_, terms_, now);
    if (c_.is_induction) system.each_step([&](const Step& step) { check_step(system, now, step); });
    if (c_.claim == "deadlock-free") {
      const z3::expr has_step = system.has_step();
      demand(no(either(system.state_fault(), has_step)), "a state that satisfies all rows has no step");
    } else if (c_.claim == "error-free") {
      demand(either(system.state_fault(), system.guard_fault()), "a state that satisfies all rows ends with an error");
    } else {
      const std::vector<Tree> claim = read_trees(c_.claim);
      if (claim.size() != 2 || claim[0].text != "never") throw Rejected("the claim `" + c_.claim + "`");
      const z3::expr bad = system.claim(claim[1]);
      demand(both(no(system.state_fault()), bad), "a state that satisfies all rows is what should never be");
    }
  }

 private:
  // There is no state like that.
  void demand(const z3::expr& bad, const std::string& otherwise) {
    if (is(bad.simplify(), false)) return;
    solver_.push();
    solver_.add(bad);
    const z3::check_result answer = solver_.check();
    solver_.pop();
    if (answer == z3::sat) throw Rejected(otherwise);
    if (answer != z3::unsat) throw NotCheckable("the solver gives up");
  }

  void check_step(const System& system, const State& now, const Step& step) {
    State after = now;
    for (const auto& [atom, local] : step.next) after[atom] = local;
    const z3::expr taken = both(step.possible, no(system.state_fault()));
    z3::expr broken = terms_.truth(false);
    for (const Fact& fact : c_.facts) {
      const bool moves = std::any_of(fact.literals.begin(), fact.literals.end(), [&](const Literal& l) { return step.next.contains(l.atom); });
      if (moves) broken = either(broken, no(holds(fact, after)));
    }
    demand(both(taken, both(no(step.trouble.fault), broken)), "a step leads out of the lemmas");
    demand(both(taken, step.trouble.lost), "internal transitions go on for too long to be followed");
    if (c_.claim == "error-free") demand(both(taken, step.trouble.fault), "a step ends with an error");
  }

  [[nodiscard]] z3::expr holds(const Literal& l, const State& state) {
    const z3::expr v = l.about == Literal::Place ? state[l.atom].marks[l.row] : state[l.atom].slots[l.row];
    z3::expr result = v;
    if (l.about == Literal::Bit && !v.is_bool()) result = v.extract(static_cast<unsigned>(l.low), static_cast<unsigned>(l.low)) == z_.bv_val(1, 1);
    if (l.about == Literal::Value) result = v.is_bool() ? v == terms_.truth(l.low != 0) : v == z_.bv_val(l.low, 32);
    if (l.about == Literal::Range && v.is_bool()) result = (l.low <= 0 || v) && (l.high >= 1 || !v);
    if (l.about == Literal::Range && !v.is_bool()) result = v >= z_.bv_val(l.low, 32) && v <= z_.bv_val(l.high, 32);
    return (l.is_negated ? !result : result).simplify();
  }
  [[nodiscard]] z3::expr holds(const Fact& fact, const State& state) {
    z3::expr some = terms_.truth(false);
    for (const Literal& literal : fact.literals) some = either(some, holds(literal, state));
    return some;
  }

  void exactly_one(const z3::expr_vector& all) {
    solver_.add(z3::mk_or(all));
    if (all.size() > 1) solver_.add(z3::atmost(all, 1));
  }

  // What has been found to hold: a mode for each atom, which says where it is; the sets.
  void assume_modes(State& now) {
    std::vector<std::map<std::size_t, z3::expr>> modes(m_.atoms.size());
    for (std::size_t a = 0; a < m_.atoms.size(); ++a) {
      const AtomType& type = m_.type_of(a);
      z3::expr_vector all(z_);
      if (c_.classes.empty()) {
        for (const z3::expr& mark : now[a].marks) all.push_back(mark);
        if (type.is_automaton) exactly_one(all);
        continue;
      }
      const Class& row = c_.classes[c_.class_of[a]];
      std::fill(now[a].marks.begin(), now[a].marks.end(), terms_.truth(false));
      for (std::size_t number : c_.reachable[a]) {
        const z3::expr mode = modes[a].emplace(number, terms_.fresh("bool")).first->second;
        all.push_back(mode);
        for (std::size_t place : row.modes[number].places) now[a].marks[place] = either(now[a].marks[place], mode);
        solver_.add(z3::implies(mode, terms_.has_values(type, now[a], row.modes[number].values)));
      }
      exactly_one(all);
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
      if (members.empty()) solver_.add(terms_.truth(!set.is_trap && set.total == 0));
      else solver_.add(set.is_trap ? z3::mk_or(members) : z3::pbeq(members, weights.data(), set.total));
    }
  }

  const Model& m_;
  const Certificate& c_;
  z3::context z_;
  Terms terms_;
  z3::solver solver_;
};

}  // namespace

void check_states(const Model& model, const Certificate& certificate) { States(model, certificate).run(); }

std::string check(const Model& model, const std::string& text) {
  const Certificate certificate = read_certificate(model, text);
  if (certificate.reached != kNone) return check_reached(model, certificate);
  if (!certificate.classes.empty()) check_structure(model, certificate);
  check_states(model, certificate);
  return std::to_string(model.atoms.size()) + " components, " + std::to_string(certificate.sets.size()) + " invariants" +
         (certificate.is_induction ? ", " + std::to_string(certificate.facts.size()) + " ranges and lemmas" : "");
}

}  // namespace certcheck
