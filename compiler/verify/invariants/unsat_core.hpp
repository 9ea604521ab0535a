// Unsat core minimisation: reduces the traps of a proof to those in the core of the solver's contradiction.
//
// Each trap stands behind an activation literal; all are assumed. One more SAT call; the core need not be minimal.
// State-machine components and place invariants have no activation literal and stay.
#pragma once
#include "compiler/verify/solver/solver.hpp"
#include "compiler/verify/invariants/token_invariant.hpp"

namespace bip::verify {

/// Removes invariants whose activation literal is not in the core; 0: the invariant has none and stays. False, and
/// nothing changes: the solver finds no contradiction in the time.
inline bool minimize_by_unsat_core(Solver& solver, std::vector<TokenInvariant>& invariants,
                                   const std::vector<Lit>& activations, const CancellationToken& cancellation) {
  for (Lit literal : activations) {
    if (literal != 0) solver.assume(literal);
  }
  if (solver.solve(cancellation) != Answer::Unsatisfiable) return false;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < activations.size(); ++k) {
    if (activations[k] != 0 && !solver.is_needed(activations[k])) continue;
    if (kept != k) invariants[kept] = std::move(invariants[k]);
    ++kept;
  }
  invariants.resize(kept);
  return true;
}

}  // namespace bip::verify
