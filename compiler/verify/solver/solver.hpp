// An incremental SAT solver behind an interface of our own: clauses go in, a model or an unsat core comes out. The
// library's headers (CaDiCaL) are included by solver.cpp alone.
#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

/// A literal: variable v > 0 as v, its negation as -v.
using Lit = int;

enum class Answer : std::uint8_t { Satisfiable, Unsatisfiable, Unknown };

/// Usual: with the simplifications of the library. Plain: without, for very many small calls. Backjumping: plain, and a
/// conflict undoes all decisions down to the level that its clause names; for conflicts that are many and near the
/// assumptions, where chronological backtracking keeps assignments that the next one undoes.
enum class SolverStyle : std::uint8_t { Usual, Plain, Backjumping };

class Solver {
 public:
  explicit Solver(SolverStyle style = SolverStyle::Usual);
  ~Solver();
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  /// Returns the positive literal of a new variable. Clauses and assumptions use only literals of such variables.
  [[nodiscard]] Lit new_variable();
  /// Adds a clause for good; an empty one makes every answer Unsatisfiable.
  void add(std::span<const Lit> clause);
  void add(std::initializer_list<Lit> clause) { add(std::span<const Lit>(clause.begin(), clause.size())); }
  /// Assumes the literal for the next solve only.
  void assume(Lit literal);
  /// Makes decisions try this value of the variable first. Speed only; answers are unaffected.
  void prefer(Lit literal);
  /// Searches for a model of all clauses under the assumptions, which it consumes. Unknown: the token is over, which
  /// the solver polls at every 16th decision or conflict, and the source of the token at each.
  [[nodiscard]] Answer solve(const CancellationToken& cancellation);
  /// Is the assumption in the unsat core of the last answer? Requires that it was Unsatisfiable.
  [[nodiscard]] bool is_needed(Lit assumption) const;
  /// Returns the literal's value in the model. Requires that the last answer was Satisfiable.
  [[nodiscard]] bool is_true(Lit literal) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Adds clauses that make at most one of the literals true: pairwise up to six, else a sequential counter (Sinz 2005)
/// with one new variable per literal.
void add_at_most_one(Solver& solver, std::span<const Lit> literals);

}  // namespace bip::verify
