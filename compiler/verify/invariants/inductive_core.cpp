// See inductive_core.hpp.
#include "compiler/verify/invariants/inductive_core.hpp"

#include <algorithm>
#include <numeric>

#include "compiler/verify/symbolic/cnf.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class InductiveCore {
 public:
  InductiveCore(const Ic3Problem& problem, const std::vector<std::vector<Cube>>& groups)
      : problem_(problem), system_(*problem.system), cnf_(system_.aig, solver_), is_needed_(groups.size(), 0) {
    transition_activation_ = cnf_.add_step(system_, problem_.invariants);
    for (const std::vector<Cube>& group : groups) encode(group);
  }

  /// By group. Empty: not found.
  std::vector<std::uint8_t> run() {
    const Lit bad = cnf_.literal(problem_.bad);
    if (!add_core({-transition_activation_, bad})) return {};
    while (!todo_.empty()) {
      const std::size_t group = todo_.back();
      todo_.pop_back();
      if (!add_core({transition_activation_, entered_[group]})) return {};
    }
    return std::move(is_needed_);
  }

 private:
  [[nodiscard]] Lit literal(Signal signal, u32 cube_literal) {
    const Lit positive = cnf_.literal(signal);
    return cube_value(cube_literal) ? positive : -positive;
  }
  // Two activation literals per group: its lemmas hold now; one of its cubes is entered.
  void encode(const std::vector<Cube>& group) {
    holds_.push_back(solver_.new_variable());
    entered_.push_back(solver_.new_variable());
    std::vector<Lit> some{-entered_.back()};
    for (const Cube& cube : group) {
      std::vector<Lit> clause{-holds_.back()};
      some.push_back(solver_.new_variable());
      for (u32 cube_literal : cube) {
        const StateBit& bit = system_.bits[cube_bit(cube_literal)];
        clause.push_back(-literal(bit.now, cube_literal));
        solver_.add({-some.back(), literal(bit.next, cube_literal)});
      }
      solver_.add(clause);
    }
    solver_.add(some);
  }
  // Adds the groups that contradict what is assumed: none beyond the needed ones if possible, else of the first ones.
  bool add_core(const std::vector<Lit>& assumed) {
    const std::size_t count = holds_.size();
    for (std::size_t first = 0; true; first = first == 0 ? (count + 15) / 16 : std::min(count, 2 * first)) {
      for (Lit lit : assumed) solver_.assume(lit);
      for (std::size_t group = 0; group < count; ++group) {
        if (group < first || is_needed_[group] != 0) solver_.assume(holds_[group]);
      }
      const Answer answer = solver_.solve(problem_.cancellation);
      if (answer == Answer::Unknown || (answer == Answer::Satisfiable && first == count)) return false;
      if (answer == Answer::Satisfiable) continue;
      for (std::size_t group = 0; group < first; ++group) {
        if (is_needed_[group] != 0 || !solver_.is_needed(holds_[group])) continue;
        is_needed_[group] = 1;
        todo_.push_back(group);
      }
      return true;
    }
  }

  const Ic3Problem& problem_;
  const TransitionSystem& system_;
  Solver solver_;
  Cnf cnf_;
  Lit transition_activation_ = 0;
  std::vector<Lit> holds_, entered_;     // by group
  std::vector<std::uint8_t> is_needed_;  // by group
  std::vector<std::size_t> todo_;        // needed groups whose own reasons are not looked for yet
};

}  // namespace

std::vector<std::size_t> inductive_core(const Ic3Problem& problem, const std::vector<std::vector<Cube>>& groups) {
  BIP_ASSERT(!groups.empty(), "no lemmas");
  const std::vector<std::uint8_t> is_needed = InductiveCore(problem, groups).run();
  std::vector<std::size_t> rows(groups.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  if (!is_needed.empty()) std::erase_if(rows, [&](std::size_t row) { return is_needed[row] == 0; });
  return rows;
}

}  // namespace bip::verify
