// An incremental SAT solver: clauses in, a model or "no" out. The only door to the solver's library.
#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

/// A literal: variable v > 0 as v, its negation as -v.
using Lit = int;

enum class Answer : std::uint8_t { Satisfiable, Unsatisfiable, Unknown };

/// Plain: no simplification between calls, for very many small questions.
enum class SolverStyle : std::uint8_t { Usual, Plain };

class Solver {
 public:
  explicit Solver(SolverStyle style = SolverStyle::Usual);
  ~Solver();
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  [[nodiscard]] Lit new_variable();
  void add(std::span<const Lit> clause);
  void add(std::initializer_list<Lit> clause) { add(std::span<const Lit>(clause.begin(), clause.size())); }
  /// Holds for the next solve only.
  void assume(Lit literal);
  /// Decisions try this value first.
  void prefer(Lit literal);
  /// Searches for a model of all clauses under the assumptions, which it consumes. Unknown: the token is over, which
  /// the solver polls at each conflict.
  [[nodiscard]] Answer solve(const CancellationToken& cancellation);
  /// After Unsatisfiable: did the answer need this assumption?
  [[nodiscard]] bool is_needed(Lit assumption) const;
  /// In the model of the last solve.
  [[nodiscard]] bool is_true(Lit literal) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// At most one of the literals: pairs up to six, else a sequential counter (Sinz 2005).
void add_at_most_one(Solver& solver, std::span<const Lit> literals);

}  // namespace bip::verify
