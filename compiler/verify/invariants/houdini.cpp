// See houdini.hpp.
#include "compiler/verify/invariants/houdini.hpp"

#include <algorithm>

#include "compiler/verify/symbolic/cnf.hpp"

namespace bip::verify {

namespace {

class Checker {
 public:
  Checker(const Ic3Problem& problem, std::vector<Cube> cubes)
      : p_(problem), m_(*problem.machine), cubes_(std::move(cubes)), cnf_(m_.circuit, solver_) {}

  InductiveLemmas run() {
    std::erase_if(cubes_, [&](const Cube& cube) { return cube.empty() || meets_initial(cube, m_); });
    if (cubes_.empty()) return {};
    add_machine();
    add_cubes();
    std::vector<std::uint8_t> holds(cubes_.size(), 1);
    while (true) {
      solver_.assume(going_);
      assume(holds);
      const Answer answer = solver_.solve(p_.cancellation);
      if (answer == Answer::Unknown) return {};
      if (answer == Answer::Unsatisfiable) break;
      for (std::size_t k = 0; k < cubes_.size(); ++k) {
        if (std::all_of(cubes_[k].begin(), cubes_[k].end(),
                        [&](u32 code) { return solver_.is_true(literal(code, true)); }))
          holds[k] = 0;
      }
    }
    InductiveLemmas result;
    // A bad state may have no step at all.
    solver_.assume(-going_);
    solver_.assume(cnf_.literal(p_.bad));
    for (std::size_t k = 0; k < cubes_.size(); ++k) {
      if (holds[k] != 0) solver_.assume(outside_[k]);
    }
    result.is_enough = solver_.solve(p_.cancellation) == Answer::Unsatisfiable;
    for (std::size_t k = 0; k < cubes_.size(); ++k) {
      if (holds[k] != 0) result.lemmas.push_back(std::move(cubes_[k]));
    }
    return result;
  }

 private:
  [[nodiscard]] Lit literal(u32 code, bool is_next) {
    const StateBit& bit = m_.bits[code / 2];
    const Lit positive = cnf_.literal(is_next ? bit.next : bit.now);
    return (code & 1) != 0 ? positive : -positive;
  }

  // A step that is fine, switched on by going_, from a state in which all is true that always is.
  void add_machine() {
    going_ = solver_.new_variable();
    std::vector<Lit> chosen;
    for (const SystemStep& step : m_.steps) {
      chosen.push_back(cnf_.literal(step.chosen));
      solver_.add({-going_, -chosen.back(), cnf_.literal(step.fine)});
    }
    add_at_most_one(solver_, chosen);
    chosen.push_back(-going_);
    solver_.add(chosen);
    cnf_.add_state(m_);
    for (const std::vector<Signal>& clause : p_.invariants) cnf_.add(clause);
  }
  void add_cubes() {
    std::vector<Lit> some{-going_};
    for (const Cube& cube : cubes_) {
      outside_.push_back(solver_.new_variable());
      entered_.push_back(solver_.new_variable());
      some.push_back(entered_.back());
      std::vector<Lit> clause{-outside_.back()};
      for (u32 code : cube) {
        clause.push_back(-literal(code, false));
        solver_.add({-entered_.back(), literal(code, true)});
      }
      solver_.add(clause);
    }
    solver_.add(some);
  }
  // From outside of all that are left, into one of them.
  void assume(const std::vector<std::uint8_t>& holds) {
    for (std::size_t k = 0; k < cubes_.size(); ++k) solver_.assume(holds[k] != 0 ? outside_[k] : -entered_[k]);
  }

  const Ic3Problem& p_;
  const TransitionSystem& m_;
  std::vector<Cube> cubes_;
  Solver solver_;
  Cnf cnf_;
  Lit going_ = 0;
  std::vector<Lit> outside_, entered_;  // by cube
};

}  // namespace

InductiveLemmas houdini(const Ic3Problem& problem, std::vector<Cube> candidates) {
  return Checker(problem, std::move(candidates)).run();
}

std::vector<Signal> clause_of(const Cube& cube, const TransitionSystem& machine) {
  std::vector<Signal> clause;
  for (u32 code : cube) {
    const Signal now = machine.bits[code / 2].now;
    clause.push_back((code & 1) != 0 ? negated(now) : now);
  }
  return clause;
}

}  // namespace bip::verify
