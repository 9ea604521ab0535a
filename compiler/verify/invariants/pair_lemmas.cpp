// See pair_lemmas.hpp.
#include "compiler/verify/invariants/pair_lemmas.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "compiler/base/log.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/symbolic/cnf.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// States before a bad one that are looked at, and how far back.
constexpr std::size_t kMostBefore = 4;
constexpr u32 kMostDepth = 3;

Lit value_of(u32 literal, Lit positive) { return cube_value(literal) ? positive : -positive; }

// Which cubes does a step enter from outside, from a state that satisfies all that is known?
class EnteringStep {
 public:
  explicit EnteringStep(const Ic3Problem& problem)
      : problem_(problem), system_(*problem.system), solver_(SolverStyle::Plain), cnf_(system_.aig, solver_) {
    is_step_ = cnf_.add_step(system_, problem.invariants);
    for (const StateBit& bit : system_.bits) now_.push_back(cnf_.literal(bit.now));
  }
  void add(const Cube& lemma) {
    std::vector<Lit> clause;
    for (const u32 literal : lemma) clause.push_back(-now(literal));
    solver_.add(clause);
  }
  /// Returns the literals of an inductive part of the cube that a proof needs; nothing: a step enters it, or the time
  /// is over.
  std::optional<Cube> inductive_part(const Cube& cube) {
    const Lit is_outside = solver_.new_variable();
    std::vector<Lit> clause{-is_outside};
    for (const u32 literal : cube) clause.push_back(-now(literal));
    solver_.add(clause);
    solver_.assume(is_step_);
    solver_.assume(is_outside);
    for (const u32 literal : cube) solver_.assume(next(literal));
    const Answer answer = solver_.solve(problem_.cancellation);
    const bool is_inductive = answer == Answer::Unsatisfiable;
    before_.clear();
    if (answer == Answer::Satisfiable) {
      for (const Lit bit : now_) before_.push_back(solver_.is_true(bit) ? 1 : 0);
    }
    Cube needed;
    if (is_inductive) {
      std::copy_if(cube.begin(), cube.end(), std::back_inserter(needed),
                   [&](u32 literal) { return solver_.is_needed(next(literal)); });
    }
    solver_.add({-is_outside});
    if (!is_inductive) return std::nullopt;
    return needed;
  }
  /// By bit: the state from which a step enters the last cube; empty: none does, or the time was over.
  [[nodiscard]] const std::vector<std::uint8_t>& before() const { return before_; }

 private:
  [[nodiscard]] Lit now(u32 literal) const { return value_of(literal, now_[cube_bit(literal)]); }
  [[nodiscard]] Lit next(u32 literal) { return value_of(literal, cnf_.literal(system_.bits[cube_bit(literal)].next)); }

  const Ic3Problem& problem_;
  const TransitionSystem& system_;
  Solver solver_;
  Cnf cnf_;
  Lit is_step_ = 0;
  std::vector<Lit> now_;  // by bit
  std::vector<std::uint8_t> before_;
};

// Bad states that satisfy all that is known; they may have no step.
class BadState {
 public:
  explicit BadState(const Ic3Problem& problem) : problem_(problem), cnf_(problem.system->aig, solver_) {
    solver_.add({-cnf_.add_step(*problem.system, problem.invariants)});
    solver_.add({cnf_.literal(problem.bad)});
    for (const StateBit& bit : problem.system->bits) now_.push_back(cnf_.literal(bit.now));
  }
  void add(const Cube& lemma) {
    std::vector<Lit> clause;
    for (const u32 literal : lemma) clause.push_back(-value_of(literal, now_[cube_bit(literal)]));
    solver_.add(clause);
  }
  /// By bit; empty: there is none, or the time is over.
  std::vector<std::uint8_t> find() {
    if (solver_.solve(problem_.cancellation) != Answer::Satisfiable) return {};
    std::vector<std::uint8_t> state;
    for (const Lit bit : now_) state.push_back(solver_.is_true(bit) ? 1 : 0);
    return state;
  }

 private:
  const Ic3Problem& problem_;
  Solver solver_;
  Cnf cnf_;
  std::vector<Lit> now_;
};

class PairLemmas {
 public:
  PairLemmas(const Ic3Problem& problem, const System& system)
      : problem_(problem), machine_(*problem.system), system_(system), bad_(problem), entering_(problem) {
    bits_of_.resize(machine_.marks.size());
    for (u32 row = 0; row < machine_.bits.size(); ++row) {
      const StateBit& bit = machine_.bits[row];
      bits_of_[bit.atom].push_back(row);
      row_of_[{bit.atom, bit.is_place ? 1u : 0u, bit.row, bit.position}] = row;
    }
  }

  std::vector<Cube> run() {
    while (!problem_.cancellation.is_over()) {
      const std::vector<std::uint8_t> state = bad_.find();
      if (state.empty() || !excludes(state, kMostDepth)) break;
    }
    BIP_LOG(Houdini, 1, "{} lemmas about pairs", lemmas_.size());
    return std::move(lemmas_);
  }

 private:
  // One pair after the other, as long as the state satisfies the lemmas: one that excludes it is enough. If there is
  // none, one that excludes a state before it may help: of a few such states, `depth` steps back.
  bool excludes(const std::vector<std::uint8_t>& state, u32 depth) {
    std::vector<std::vector<std::uint8_t>> before;
    for (u32 a = 0; a < bits_of_.size(); ++a) {
      for (u32 b = a + 1; b < bits_of_.size(); ++b) {
        const Cube cube = projection_of(state, a, b);
        // The projection recurs in other bad states.
        const auto known = entered_.find(cube);
        if (problem_.cancellation.is_over() || (known != entered_.end() && known->second == lemmas_.size())) continue;
        if (const std::optional<Cube> lemma = lemma_within(cube)) {
          learn(*lemma);
          return true;
        }
        entered_[cube] = lemmas_.size();
        if (!entering_.before().empty() && before.size() < kMostBefore) before.push_back(entering_.before());
      }
    }
    return depth != 0 && std::any_of(before.begin(), before.end(), [&](const std::vector<std::uint8_t>& earlier) {
             return excludes(earlier, depth - 1);
           });
  }
  [[nodiscard]] Cube projection_of(const std::vector<std::uint8_t>& state, u32 a, u32 b) const {
    Cube cube;
    for (const u32 atom : {a, b}) {
      for (const u32 bit : bits_of_[atom]) cube.push_back(cube_literal_of(bit, state[bit] != 0));
    }
    std::sort(cube.begin(), cube.end());
    return cube;
  }
  // A part of the cube that no step enters: what a step enters from outside has in common with where it comes from must
  // be excluded together (Bradley and Manna's down).
  std::optional<Cube> lemma_within(Cube cube) {
    while (!cube.empty() && !meets_initial(cube, machine_)) {
      if (std::optional<Cube> part = entering_.inductive_part(cube))
        return generalised(std::move(cube), std::move(*part));
      const std::vector<std::uint8_t>& before = entering_.before();
      if (before.empty()) return std::nullopt;
      std::erase_if(cube, [&](u32 literal) { return (before[cube_bit(literal)] != 0) != cube_value(literal); });
    }
    return std::nullopt;
  }
  // Drops literals as long as no step enters the rest. `part`: what a proof of the cube needs.
  Cube generalised(Cube cube, Cube part) {
    const auto try_part = [&](Cube smaller) {
      if (smaller.size() == cube.size() || meets_initial(smaller, machine_)) return false;
      const std::optional<Cube> needed = entering_.inductive_part(smaller);
      if (!needed) return false;
      cube = std::move(smaller);
      return true;
    };
    (void)try_part(std::move(part));
    for (std::size_t k = cube.size(); k-- > 0 && cube.size() > 1;) {
      Cube smaller = cube;
      smaller.erase(smaller.begin() + static_cast<std::ptrdiff_t>(k));
      (void)try_part(std::move(smaller));
    }
    return cube;
  }
  // With its images, as far as they are inductive, too.
  void learn(const Cube& lemma) {
    std::set<Cube> images{lemma};
    const u32 first = machine_.bits[cube_bit(lemma.front())].atom, second = machine_.bits[cube_bit(lemma.back())].atom;
    for (u32 a = 0; a < bits_of_.size(); ++a) {
      if (type_of(a) != type_of(first)) continue;
      for (u32 b = 0; b < bits_of_.size(); ++b) {
        if (type_of(b) != type_of(second) || (a == b) != (first == second)) continue;
        if (std::optional<Cube> image = image_of(lemma, first, a, b)) images.insert(std::move(*image));
      }
    }
    // Each by itself with those before; the first is known to be inductive.
    add(lemma);
    images.erase(lemma);
    for (const Cube& image : images) {
      if (known_.contains(image) || meets_initial(image, machine_)) continue;
      if (entering_.inductive_part(image)) add(image);
    }
  }
  void add(const Cube& lemma) {
    bad_.add(lemma);
    entering_.add(lemma);
    known_.insert(lemma);
    lemmas_.push_back(lemma);
  }
  [[nodiscard]] AtomTypeId type_of(u32 atom) const { return system_.atoms[AtomId(std::size_t{atom})].type; }
  // The lemma of `first` and another atom, said of a and b. Nothing if these lack a bit: their ranges are smaller.
  [[nodiscard]] std::optional<Cube> image_of(const Cube& lemma, u32 first, u32 a, u32 b) const {
    Cube image;
    for (const u32 literal : lemma) {
      const StateBit& bit = machine_.bits[cube_bit(literal)];
      const auto at = row_of_.find({bit.atom == first ? a : b, bit.is_place ? 1u : 0u, bit.row, bit.position});
      if (at == row_of_.end()) return std::nullopt;
      image.push_back(cube_literal_of(at->second, cube_value(literal)));
    }
    std::sort(image.begin(), image.end());
    return image;
  }

  const Ic3Problem& problem_;
  const TransitionSystem& machine_;
  const System& system_;
  BadState bad_;
  EnteringStep entering_;
  std::vector<std::vector<u32>> bits_of_;     // by atom
  std::map<std::array<u32, 4>, u32> row_of_;  // of bits: atom, is it a place, row, position
  std::map<Cube, std::size_t> entered_;       // projections without a lemma, with so many lemmas
  std::set<Cube> known_;
  std::vector<Cube> lemmas_;
};

}  // namespace

std::vector<Cube> find_pair_lemmas(const Ic3Problem& problem, const System& system) {
  if (problem.system->marks.size() > kMostAtomsOfPairs) return {};
  return PairLemmas(problem, system).run();
}

}  // namespace bip::verify
