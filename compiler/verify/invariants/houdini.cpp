// See houdini.hpp. Departure from the paper: one query asks for a counterexample to any of the candidates, so each
// query refutes at least one of them and the last one proves all.
#include "compiler/verify/invariants/houdini.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "compiler/base/log.hpp"
#include "compiler/verify/symbolic/cnf.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class Houdini {
 public:
  Houdini(const Ic3Problem& problem, std::vector<Cube> candidates)
      : problem_(problem), system_(*problem.system), candidates_(std::move(candidates)), cnf_(system_.aig, solver_) {}

  InductiveLemmas run() {
    // Base case: a lemma holds in all initial states.
    std::erase_if(candidates_, [&](const Cube& cube) { return cube.empty() || meets_initial(cube, system_); });
    if (candidates_.empty()) return {};
    encode_transition_relation();
    encode_candidates();
    std::vector<std::uint8_t> holds(candidates_.size(), 1);
    // Induction step: from all remaining candidates into a state that breaks one of them. A round assumes those that
    // remained when it began; what is refuted then is refuted by the fewer that remain, too.
    for (bool is_refuted = true; is_refuted;) {
      begin_round(holds);
      is_refuted = false;
      while (true) {
        solver_.assume(transition_activation_);
        solver_.assume(round_activation_);
        const Answer answer = solver_.solve(problem_.cancellation);
        if (answer == Answer::Unknown) return {};
        if (answer == Answer::Unsatisfiable) break;
        refute_candidates(holds);
        is_refuted = true;
      }
    }
    InductiveLemmas result;
    // A bad state may have no step at all: the transition relation is off.
    solver_.assume(-transition_activation_);
    solver_.assume(cnf_.literal(problem_.bad));
    solver_.assume(round_activation_);
    result.is_enough = solver_.solve(problem_.cancellation) == Answer::Unsatisfiable;
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      if (holds[k] != 0) result.lemmas.push_back(std::move(candidates_[k]));
    }
    BIP_LOG(Houdini, 1, "{} of {} lemmas are inductive{}", result.lemmas.size(), holds.size(),
            result.is_enough ? " and exclude all bad states" : "");
    return result;
  }

 private:
  [[nodiscard]] Lit now(u32 cube_literal) { return literal(system_.bits[cube_bit(cube_literal)].now, cube_literal); }
  [[nodiscard]] Lit next(u32 cube_literal) { return literal(system_.bits[cube_bit(cube_literal)].next, cube_literal); }
  [[nodiscard]] Lit literal(Signal signal, u32 cube_literal) {
    const Lit positive = cnf_.literal(signal);
    return cube_value(cube_literal) ? positive : -positive;
  }

  // Exactly one step, which ends in no fault, from a state that satisfies the invariants.
  void encode_transition_relation() {
    transition_activation_ = solver_.new_variable();
    std::vector<Lit> chosen;
    for (const SystemStep& step : system_.steps) {
      chosen.push_back(cnf_.literal(step.chosen));
      solver_.add({-transition_activation_, -chosen.back(), cnf_.literal(step.fine)});
    }
    add_at_most_one(solver_, chosen);
    chosen.push_back(-transition_activation_);
    solver_.add(chosen);
    cnf_.add_state(system_);
    for (const std::vector<Signal>& clause : problem_.invariants) cnf_.add(clause);
  }
  // Two activation literals per candidate: it holds now; its cube is entered. With a step, some cube is entered. Cubes
  // that begin alike share the variables of what they have in common: many lemmas speak of the same range of an array.
  void encode_candidates() {
    std::vector<Lit> some{-transition_activation_};
    for (const Cube& cube : candidates_) {
      Lit in_now = 0, in_next = 0;
      for (u32 cube_literal : cube) {
        in_now = conjunction(in_now, cube_literal, State::Now);
        in_next = conjunction(in_next, cube_literal, State::Next);
      }
      holds_now_.push_back(solver_.new_variable());
      entered_.push_back(solver_.new_variable());
      some.push_back(entered_.back());
      solver_.add({-holds_now_.back(), -in_now});
      solver_.add({-entered_.back(), in_next});
    }
    solver_.add(some);
    is_open_.assign(candidates_.size(), 1);
  }
  enum class State : std::uint8_t { Now, Next };
  // `before` and the literal. Now: true if both are; Next: both are true if it is. 0: nothing before.
  Lit conjunction(Lit before, u32 cube_literal, State state) {
    const Lit last = state == State::Now ? now(cube_literal) : next(cube_literal);
    if (before == 0) return last;
    const auto [found, is_new] =
        (state == State::Now ? now_conjunctions_ : next_conjunctions_).try_emplace({before, last}, 0);
    if (!is_new) return found->second;
    const Lit both = solver_.new_variable();
    found->second = both;
    if (state == State::Now) {
      solver_.add({-before, -last, both});
    } else {
      solver_.add({-both, before});
      solver_.add({-both, last});
    }
    return both;
  }
  void begin_round(const std::vector<std::uint8_t>& holds) {
    if (round_activation_ != 0) solver_.add({-round_activation_});
    round_activation_ = solver_.new_variable();
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      if (holds[k] != 0) solver_.add({-round_activation_, holds_now_[k]});
    }
  }
  // The model's step enters the cubes of these candidates.
  void refute_candidates(std::vector<std::uint8_t>& holds) {
    const std::ptrdiff_t before = std::count(holds.begin(), holds.end(), 1);
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      if (std::all_of(candidates_[k].begin(), candidates_[k].end(),
                      [&](u32 cube_literal) { return solver_.is_true(next(cube_literal)); }))
        holds[k] = 0;
    }
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      if (holds[k] == 0 && is_open_[k] != 0) {
        is_open_[k] = 0;
        solver_.add({-entered_[k]});
      }
    }
    BIP_ASSERT(std::count(holds.begin(), holds.end(), 1) < before, "a counterexample refutes none of {} candidates",
               before);
  }

  const Ic3Problem& problem_;
  const TransitionSystem& system_;
  std::vector<Cube> candidates_;
  Solver solver_;
  Cnf cnf_;
  Lit transition_activation_ = 0;
  Lit round_activation_ = 0;              // those that remained hold now
  std::vector<Lit> holds_now_, entered_;  // by candidate
  std::vector<std::uint8_t> is_open_;     // by candidate: it may be entered
  std::map<std::pair<Lit, Lit>, Lit> now_conjunctions_, next_conjunctions_;
};

}  // namespace

InductiveLemmas houdini(const Ic3Problem& problem, std::vector<Cube> candidates) {
  return Houdini(problem, std::move(candidates)).run();
}

std::vector<Signal> clause_of(const Cube& cube, const TransitionSystem& system) {
  std::vector<Signal> clause;
  for (u32 cube_literal : cube) {
    const Signal now = system.bits[cube_bit(cube_literal)].now;
    clause.push_back(cube_value(cube_literal) ? negated(now) : now);
  }
  return clause;
}

}  // namespace bip::verify
