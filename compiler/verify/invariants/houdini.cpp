// See houdini.hpp. Departures from the paper:
// - One query asks for a counterexample to any of a group of candidates, so each query refutes at least one of them and
//   the last one proves all. The candidates of a group begin alike, and a query assumes what they have in common: of
//   ten thousand, whose cubes are words over arrays, the solver considers those about one range at a time.
// - The transition relation is partitioned: a solver has the steps of a block only (disjunctive partitioning: J. Burch,
//   E. Clarke, D. Long: Symbolic Model Checking with Partitioned Transition Relations, 1991). Which step is taken is
//   known to the solver at once, and each of its decisions sets the inputs of all steps that it has. What the steps of
//   a block do not change enters no cube, so candidates about it alone are not asked about.
#include "compiler/verify/invariants/houdini.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "compiler/base/log.hpp"
#include "compiler/verify/symbolic/cnf.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// A query about more candidates is harder than two queries.
constexpr std::size_t kMostOfGroup = 256;

[[nodiscard]] std::size_t common_literals(const Cube& a, const Cube& b) {
  return static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin());
}

// The candidates that remain, in the order of their cubes.
struct Candidates {
  explicit Candidates(std::vector<Cube> given) : cubes(std::move(given)), order(cubes.size()), holds(cubes.size(), 1) {
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return cubes[a] < cubes[b]; });
  }
  std::vector<Cube> cubes;
  std::vector<std::size_t> order;   // rows of cubes
  std::vector<std::uint8_t> holds;  // by row: no step so far breaks it
};

// Cubes that begin alike share the variables of what they have in common (many lemmas speak of the same range of an
// array): in order, each needs variables for what it does not share with the one before. A solver decides young
// variables first. These are many and follow from the state, so they are created before all others.
std::vector<Lit> create_prefix_variables(const Candidates& candidates, Solver& solver) {
  std::vector<Lit> result;
  const Cube* before = nullptr;
  for (const std::size_t row : candidates.order) {
    const Cube& cube = candidates.cubes[row];
    const std::size_t shared = before == nullptr ? 0 : common_literals(*before, cube);
    // One literal is no conjunction.
    for (std::size_t j = std::max<std::size_t>(1, shared); j < cube.size(); ++j)
      result.push_back(solver.new_variable());
    before = &cube;
  }
  return result;
}

// Adds that all candidates hold now.
void add_candidates(const Candidates& candidates, const TransitionSystem& system, const std::vector<Lit>& prefixes,
                    Cnf& cnf, Solver& solver) {
  // By length: it is true if so many literals of the cube are true.
  std::vector<Lit> all;
  const Cube* before = nullptr;
  std::size_t used = 0;
  for (const std::size_t row : candidates.order) {
    const Cube& cube = candidates.cubes[row];
    all.resize(before == nullptr ? 0 : common_literals(*before, cube));
    for (std::size_t j = all.size(); j < cube.size(); ++j) {
      const Lit positive = cnf.literal(system.bits[cube_bit(cube[j])].now);
      const Lit last = cube_value(cube[j]) ? positive : -positive;
      if (j == 0) {
        all.push_back(last);
        continue;
      }
      solver.add({-all.back(), -last, prefixes[used]});
      all.push_back(prefixes[used++]);
    }
    before = &cube;
    solver.add({-all.back()});
  }
  BIP_ASSERT(used == prefixes.size(), "{} of {} prefixes", used, prefixes.size());
}

// The steps of a block and all candidates, which hold now. Of its own solver: a clause that holds for good costs a
// query nothing, one with an activation literal is propagated anew in each.
class StepBlock {
 public:
  StepBlock(const Ic3Problem& problem, Candidates& candidates, std::size_t begin, std::size_t end, SolverStyle style)
      : problem_(problem),
        system_(*problem.system),
        candidates_(candidates),
        solver_(style),
        cnf_(system_.aig, solver_) {
    const std::vector<Lit> prefixes = create_prefix_variables(candidates, solver_);
    transition_activation_ = cnf_.add_step(system_, problem_.invariants, begin, end);
    add_candidates(candidates, system_, prefixes, cnf_, solver_);
    for (const std::size_t row : candidates.order) {
      const Cube& cube = candidates.cubes[row];
      // All bits are encoded, for a model is read of cubes whose group has not been asked about yet.
      bool is_changed = false;
      for (const u32 cube_literal : cube) {
        const StateBit& bit = system_.bits[cube_bit(cube_literal)];
        is_changed |= cnf_.literal(bit.next) != cnf_.literal(bit.now);
      }
      if (is_changed && candidates.holds[row] != 0) changed_.push_back(row);
    }
    entered_.resize(changed_.size());
    form_groups();
  }

  /// Refutes all candidates that a step from all of them breaks. False: the time is over.
  bool run() {
    for (const Group& group : groups_) {
      const Query query = encode_entering(group);
      while (true) {
        solver_.assume(transition_activation_);
        solver_.assume(query.some_is_entered);
        if (query.prefix != 0) solver_.assume(query.prefix);
        const Answer answer = solver_.solve(problem_.cancellation);
        if (answer == Answer::Unknown) return false;
        if (answer == Answer::Unsatisfiable) break;
        refute_candidates(group);
      }
      retire(group, query);
    }
    return true;
  }

  [[nodiscard]] Lit next(u32 cube_literal) {
    const Lit positive = cnf_.literal(system_.bits[cube_bit(cube_literal)].next);
    return cube_value(cube_literal) ? positive : -positive;
  }

  struct Group {
    std::size_t begin = 0, end = 0;  // in changed_
  };
  struct Query {
    Lit some_is_entered = 0;
    Lit prefix = 0;  // what all cubes of the group have in common; 0: nothing
  };

  // That a step enters a cube of the group: the youngest variables, so that the solver tries one cube after the other.
  Query encode_entering(const Group& group) {
    Query query;
    query.some_is_entered = solver_.new_variable();
    std::vector<Lit> some{-query.some_is_entered};
    // By length: it implies so many literals of the cube in the next state.
    std::vector<Lit> all_next;
    for (std::size_t k = group.begin; k < group.end; ++k) {
      const Cube& cube = changed_cube(k);
      all_next.resize(k == group.begin ? 0 : common_literals(changed_cube(k - 1), cube));
      for (std::size_t j = all_next.size(); j < cube.size(); ++j) {
        if (j == 0) {
          all_next.push_back(next(cube[j]));
          continue;
        }
        const Lit longer = solver_.new_variable();
        solver_.add({-longer, all_next.back()});
        solver_.add({-longer, next(cube[j])});
        all_next.push_back(longer);
      }
      // Refuted since the groups were formed.
      if (candidates_.holds[changed_[k]] == 0) continue;
      entered_[k] = solver_.new_variable();
      solver_.add({-entered_[k], all_next.back()});
      some.push_back(entered_[k]);
    }
    solver_.add(some);
    // All cubes between the first and the last begin as both do.
    const std::size_t common = common_literals(changed_cube(group.begin), changed_cube(group.end - 1));
    if (common != 0) query.prefix = all_next[common - 1];
    return query;
  }
  // What is asked about a group matters to no other one.
  void retire(const Group& group, const Query& query) {
    solver_.add({-query.some_is_entered});
    for (std::size_t k = group.begin; k < group.end; ++k) {
      if (entered_[k] != 0) solver_.add({-entered_[k]});
    }
  }
  // Of the cubes as a tree of prefixes: largest subtrees of at most kMostOfGroup cubes; small ones next to each other
  // with the same parent are one group.
  void form_groups() {
    struct Subtree {
      std::size_t begin = 0, end = 0, depth = 0;  // in changed_; literals in common
    };
    std::vector<Subtree> todo{{0, changed_.size(), 0}};
    while (!todo.empty()) {
      const auto [begin, end, depth] = todo.back();
      todo.pop_back();
      // A cube that ends here has no child.
      const auto child_end = [&, depth = depth, end = end](std::size_t k) {
        const Cube& first = changed_cube(k);
        if (first.size() == depth) return k + 1;
        std::size_t last = k + 1;
        while (last < end && changed_cube(last)[depth] == first[depth]) ++last;
        return last;
      };
      for (std::size_t k = begin; k < end;) {
        std::size_t last = child_end(k);
        if (last - k > kMostOfGroup) {
          todo.push_back({k, last, depth + 1});
          k = last;
          continue;
        }
        while (last < end) {
          const std::size_t further = child_end(last);
          if (further - k > kMostOfGroup) break;
          last = further;
        }
        groups_.push_back({k, last});
        k = last;
      }
    }
    std::sort(groups_.begin(), groups_.end(), [](const Group& a, const Group& b) { return a.begin < b.begin; });
  }
  // The model's step enters cubes of this group; of other groups, too, perhaps.
  void refute_candidates(const Group& group) {
    std::vector<std::size_t> entered;
    for (std::size_t k = group.begin; k < changed_.size(); ++k) {
      const Cube& cube = changed_cube(k);
      if (candidates_.holds[changed_[k]] != 0 &&
          std::all_of(cube.begin(), cube.end(), [&](u32 cube_literal) { return solver_.is_true(next(cube_literal)); }))
        entered.push_back(k);
    }
    BIP_ASSERT(!entered.empty() && entered[0] < group.end, "a counterexample refutes none of {} candidates",
               group.end - group.begin);
    for (const std::size_t k : entered) {
      candidates_.holds[changed_[k]] = 0;
      if (k < group.end) solver_.add({-entered_[k]});
    }
  }
  [[nodiscard]] const Cube& changed_cube(std::size_t k) const { return candidates_.cubes[changed_[k]]; }

  const Ic3Problem& problem_;
  const TransitionSystem& system_;
  Candidates& candidates_;
  Solver solver_;
  Cnf cnf_;
  Lit transition_activation_ = 0;
  std::vector<std::size_t> changed_;  // rows of the candidates whose bits the block's steps may change, in their order
  std::vector<Lit> entered_;          // by row of changed_; of groups that were asked about
  std::vector<Group> groups_;
};

// Refutes all candidates that a step from all of them breaks. False: the time is over.
bool refute_by_steps(const Ic3Problem& problem, Candidates& candidates, std::size_t steps_of_block) {
  const std::size_t steps = problem.system->steps.size();
  // Blocks of about the same size.
  const std::size_t blocks = std::max<std::size_t>(1, (steps + steps_of_block - 1) / steps_of_block);
  // The solver of one block of many is asked too little for simplifications to pay.
  const SolverStyle style = blocks == 1 ? SolverStyle::Usual : SolverStyle::Backjumping;
  for (std::size_t block = 0; block < blocks; ++block) {
    if (!StepBlock(problem, candidates, steps * block / blocks, steps * (block + 1) / blocks, style).run())
      return false;
  }
  return true;
}

bool exclude_bad_states(const Ic3Problem& problem, const Candidates& lemmas) {
  Solver solver;
  Cnf cnf(problem.system->aig, solver);
  const std::vector<Lit> prefixes = create_prefix_variables(lemmas, solver);
  // A bad state may have no step at all: the transition relation is off.
  solver.add({-cnf.add_step(*problem.system, problem.invariants)});
  add_candidates(lemmas, *problem.system, prefixes, cnf, solver);
  solver.add({cnf.literal(problem.bad)});
  return solver.solve(problem.cancellation) == Answer::Unsatisfiable;
}

}  // namespace

InductiveLemmas houdini(const Ic3Problem& problem, std::vector<Cube> candidates, std::size_t steps_of_block) {
  BIP_ASSERT(steps_of_block > 0, "blocks of no step");
  const std::size_t count = candidates.size();
  // Base case: a lemma holds in all initial states.
  std::erase_if(candidates, [&](const Cube& cube) { return cube.empty() || meets_initial(cube, *problem.system); });
  // Induction step: from all remaining candidates into a state that breaks one of them. What is refuted in a round is
  // refuted by the fewer that remain, too.
  while (!candidates.empty()) {
    Candidates remaining(std::move(candidates));
    if (!refute_by_steps(problem, remaining, steps_of_block)) return {};
    if (std::find(remaining.holds.begin(), remaining.holds.end(), 0) == remaining.holds.end()) {
      const bool is_enough = exclude_bad_states(problem, remaining);
      BIP_LOG(Houdini, 1, "{} of {} lemmas are inductive{}", remaining.cubes.size(), count,
              is_enough ? " and exclude all bad states" : "");
      return {std::move(remaining.cubes), is_enough};
    }
    candidates = std::move(remaining.cubes);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      if (remaining.holds[k] == 0) continue;
      if (kept != k) candidates[kept] = std::move(candidates[k]);
      ++kept;
    }
    candidates.resize(kept);
  }
  BIP_LOG(Houdini, 1, "none of {} lemmas is inductive", count);
  return {};
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
