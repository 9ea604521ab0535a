// See houdini.hpp. Departure from the paper: one query asks for a counterexample to any of a group of candidates, so
// each query refutes at least one of them and the last one proves all. The candidates of a group begin alike, and a
// query assumes what they have in common: of ten thousand, whose cubes are words over arrays, the solver considers
// those about one range at a time.
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

// The candidates that remain, all of which hold now. Of its own solver: a clause that holds for good costs a query
// nothing, one with an activation literal is propagated anew in each.
class HoudiniRound {
 public:
  HoudiniRound(const Ic3Problem& problem, const std::vector<Cube>& candidates)
      : problem_(problem),
        system_(*problem.system),
        candidates_(candidates),
        cnf_(system_.aig, solver_),
        holds_(candidates.size(), 1) {
    transition_activation_ = cnf_.add_step(system_, problem_.invariants);
    encode_candidates();
  }

  /// Refutes all candidates that a step from all of them breaks: by candidate 0. Empty: the time is over.
  std::vector<std::uint8_t> run() {
    for (const Group& group : groups_) {
      while (true) {
        solver_.assume(transition_activation_);
        solver_.assume(group.some_is_entered);
        if (group.prefix != 0) solver_.assume(group.prefix);
        const Answer answer = solver_.solve(problem_.cancellation);
        if (answer == Answer::Unknown) return {};
        if (answer == Answer::Unsatisfiable) break;
        refute_candidates();
      }
    }
    return holds_;
  }
  bool excludes_bad_states() {
    // A bad state may have no step at all: the transition relation is off.
    solver_.assume(-transition_activation_);
    solver_.assume(cnf_.literal(problem_.bad));
    return solver_.solve(problem_.cancellation) == Answer::Unsatisfiable;
  }

 private:
  [[nodiscard]] Lit now(u32 cube_literal) { return literal(system_.bits[cube_bit(cube_literal)].now, cube_literal); }
  [[nodiscard]] Lit next(u32 cube_literal) { return literal(system_.bits[cube_bit(cube_literal)].next, cube_literal); }
  [[nodiscard]] Lit literal(Signal signal, u32 cube_literal) {
    const Lit positive = cnf_.literal(signal);
    return cube_value(cube_literal) ? positive : -positive;
  }

  struct Group {
    std::size_t begin = 0, end = 0;  // in order_
    Lit some_is_entered = 0;
    Lit prefix = 0;  // what all of its cubes have in common; 0: nothing
  };

  // Two activation literals per candidate: it holds now; its cube is entered. Cubes that begin alike share the
  // variables of what they have in common (many lemmas speak of the same range of an array): in order, each needs
  // variables for what it does not share with the one before.
  void encode_candidates() {
    order_.resize(candidates_.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::sort(order_.begin(), order_.end(),
              [&](std::size_t a, std::size_t b) { return candidates_[a] < candidates_[b]; });
    form_groups();
    entered_.resize(candidates_.size());
    // By length: the conjunction of so many literals of the cube. Now: true if all are; next: all are true if it is.
    std::vector<Lit> all_now, all_next;
    const Cube* before = nullptr;
    for (Group& group : groups_) {
      group.some_is_entered = solver_.new_variable();
      std::vector<Lit> some{-group.some_is_entered};
      for (std::size_t k = group.begin; k < group.end; ++k) {
        const Cube& cube = candidates_[order_[k]];
        const std::size_t shared = before == nullptr ? 0 : common_literals(*before, cube);
        all_now.resize(shared);
        all_next.resize(shared);
        for (std::size_t j = shared; j < cube.size(); ++j) {
          all_now.push_back(both(j == 0 ? 0 : all_now.back(), now(cube[j]), State::Now));
          all_next.push_back(both(j == 0 ? 0 : all_next.back(), next(cube[j]), State::Next));
        }
        before = &cube;
        solver_.add({-all_now.back()});
        const Lit entered = solver_.new_variable();
        entered_[order_[k]] = entered;
        solver_.add({-entered, all_next.back()});
        some.push_back(entered);
      }
      solver_.add(some);
      // All cubes between the first and the last of a group begin as both do.
      const std::size_t common = common_literals(candidates_[order_[group.begin]], candidates_[order_[group.end - 1]]);
      if (common != 0) group.prefix = all_next[common - 1];
    }
  }
  static std::size_t common_literals(const Cube& a, const Cube& b) {
    return static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin());
  }
  enum class State : std::uint8_t { Now, Next };
  Lit both(Lit before, Lit last, State state) {
    if (before == 0) return last;
    const Lit result = solver_.new_variable();
    if (state == State::Now) {
      solver_.add({-before, -last, result});
    } else {
      solver_.add({-result, before});
      solver_.add({-result, last});
    }
    return result;
  }
  // Of the cubes as a tree of prefixes: largest subtrees of at most kMostOfGroup cubes; small ones next to each other
  // with the same parent are one group.
  void form_groups() {
    struct Subtree {
      std::size_t begin = 0, end = 0, depth = 0;  // in order_; literals in common
    };
    std::vector<Subtree> todo{{0, order_.size(), 0}};
    while (!todo.empty()) {
      const auto [begin, end, depth] = todo.back();
      todo.pop_back();
      // A cube that ends here has no child.
      const auto child_end = [&, depth = depth, end = end](std::size_t k) {
        const Cube& first = candidates_[order_[k]];
        if (first.size() == depth) return k + 1;
        std::size_t last = k + 1;
        while (last < end && candidates_[order_[last]][depth] == first[depth]) ++last;
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
  // The model's step enters the cubes of these candidates.
  void refute_candidates() {
    std::vector<std::size_t> entered;
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      if (holds_[k] != 0 && std::all_of(candidates_[k].begin(), candidates_[k].end(),
                                        [&](u32 cube_literal) { return solver_.is_true(next(cube_literal)); }))
        entered.push_back(k);
    }
    BIP_ASSERT(!entered.empty(), "a counterexample refutes none of {} candidates", candidates_.size());
    for (std::size_t k : entered) {
      holds_[k] = 0;
      solver_.add({-entered_[k]});
    }
  }

  const Ic3Problem& problem_;
  const TransitionSystem& system_;
  const std::vector<Cube>& candidates_;
  Solver solver_;
  Cnf cnf_;
  Lit transition_activation_ = 0;
  std::vector<Lit> entered_;        // by candidate
  std::vector<std::size_t> order_;  // rows of candidates by their cubes
  std::vector<Group> groups_;
  std::vector<std::uint8_t> holds_;  // by candidate
};

}  // namespace

InductiveLemmas houdini(const Ic3Problem& problem, std::vector<Cube> candidates) {
  const std::size_t count = candidates.size();
  // Base case: a lemma holds in all initial states.
  std::erase_if(candidates, [&](const Cube& cube) { return cube.empty() || meets_initial(cube, *problem.system); });
  // Induction step: from all remaining candidates into a state that breaks one of them. What is refuted in a round is
  // refuted by the fewer that remain, too.
  while (!candidates.empty()) {
    HoudiniRound round(problem, candidates);
    const std::vector<std::uint8_t> holds = round.run();
    if (holds.empty()) return {};
    if (std::find(holds.begin(), holds.end(), 0) == holds.end()) {
      const bool is_enough = round.excludes_bad_states();
      BIP_LOG(Houdini, 1, "{} of {} lemmas are inductive{}", candidates.size(), count,
              is_enough ? " and exclude all bad states" : "");
      return {std::move(candidates), is_enough};
    }
    std::vector<Cube> remaining;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      if (holds[k] != 0) remaining.push_back(std::move(candidates[k]));
    }
    candidates = std::move(remaining);
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
