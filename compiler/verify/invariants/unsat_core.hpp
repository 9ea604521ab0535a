// Of a proof's traps, the few that matter: each has a switch in the solver, all are assumed, and those in the core of
// the contradiction stay.
//
// One more call of the solver; the core need not be the smallest. One-token invariants and sums have no switch and
// stay.
#pragma once
#include "compiler/verify/solver/solver.hpp"
#include "compiler/verify/invariants/traps.hpp"

namespace bip::verify {

/// `on`: by invariant its switch, 0 without. Nothing changes if the solver finds no contradiction in the time.
inline bool minimize_by_unsat_core(Solver& solver, std::vector<TokenInvariant>& invariants, const std::vector<Lit>& on,
                                   const CancellationToken& cancellation) {
  for (Lit literal : on) {
    if (literal != 0) solver.assume(literal);
  }
  if (solver.solve(cancellation) != Answer::Unsatisfiable) return false;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < on.size(); ++k) {
    if (on[k] != 0 && !solver.is_needed(on[k])) continue;
    if (kept != k) invariants[kept] = std::move(invariants[k]);
    ++kept;
  }
  invariants.resize(kept);
  return true;
}

}  // namespace bip::verify
