// Affine invariants over a transition system: their initial values, the bounds of ints that they imply, both as
// signals.
//
// An equation between ints and places bounds its ints by what the places weigh. Such a bound is a candidate: it is kept
// if it holds initially and after every step from a state in which all candidates and equations hold (Houdini; C.
// Flanagan, R. Leino, 2001). One SAT query per bound and step that can change it, and again after a bound is refuted.
#pragma once
#include "compiler/verify/invariants/affine_invariants.hpp"

namespace bip::verify {

/// Computes the totals of the equations in the initial state; leaves out equations for which it is not known.
[[nodiscard]] AffineInvariants with_totals(TransitionSystem& transition_system, const rt::Image& image,
                                           AffineInvariants facts);
/// Adds totals and the bounds that are inductive. `assumed`: clauses that hold in every reachable state. No bounds if
/// the time is over.
[[nodiscard]] AffineInvariants with_bounds(const Net& net, TransitionSystem& transition_system, const rt::Image& image,
                                           const std::vector<std::vector<Signal>>& assumed,
                                           const CancellationToken& cancellation, AffineInvariants facts);
/// Returns a signal that is true in the states in which the equation holds.
[[nodiscard]] Signal equation_signal(const AffineEquation& equation, TransitionSystem& transition_system,
                                     const rt::Image& image);
[[nodiscard]] Signal bound_signal(const VariableBound& bound, TransitionSystem& transition_system,
                                  const rt::Image& image);
/// Returns the clause "not at the place, or the variable has the value".
[[nodiscard]] std::vector<Signal> place_clause(const PlaceValue& fact, TransitionSystem& transition_system,
                                               const rt::Image& image);

}  // namespace bip::verify
