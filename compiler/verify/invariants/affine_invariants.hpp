// Affine invariants: linear equations between ints and places, as "requests - 2 * at(clerk.BUSY) = the sum of
// at(user[i].WAITS)". They hold in every stable state, modulo 2^32, as the language's ints do.
//
// A transition, a transfer and an interaction change such a sum by what their code adds (affine_code.hpp) and by where
// tokens go. Requiring that every interaction changes it by nothing gives one system of homogeneous linear equations
// for the weights; each solution is an invariant (sparse_system.hpp). A guard with == adds what it fixes: "if n == 4
// then n becomes 0" subtracts 4. Cost: linear in the system's code, plus the fill of the equations.
//
// M. Karr: Affine Relationships Among Variables of a Program (1976). M. Müller-Olm, H. Seidl: Analysis of Modular
// Arithmetic (2005), for rings as Z/2^32. S. Sankaranarayanan, H. Sipma, Z. Manna: Petri Net Analysis Using Invariant
// Generation (2003). Departure from Karr: no control-flow join is computed; one weight vector for all places, as in a
// place invariant, found by elimination instead of a fixpoint.
#pragma once
#include <string>

#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/invariants/place_values.hpp"
#include "compiler/verify/portfolio/prove_by_invariants.hpp"

namespace bip::verify {

struct AffineEquation {
  struct Term {
    u32 atom = 0, row = 0;  // place or variable of its type
    bool is_place = false;
    std::int32_t weight = 0;
    friend auto operator<=>(const Term&, const Term&) = default;
  };
  std::vector<Term> terms;
  std::int32_t total = 0;
};

/// 0 <= variable <= high.
struct VariableBound {
  u32 atom = 0, variable = 0;
  std::int32_t high = 0;
};
struct AffineInvariants {
  std::vector<AffineEquation> equations;
  std::vector<VariableBound> bounds = {};  // inductive together and with the equations
  std::vector<PlaceValue> places = {};     // none if the equations were found without
};

/// Computes equations and the bounds that they imply (affine_bounds.hpp). `assumed`: clauses that hold in every
/// reachable state. The net must be usable.
[[nodiscard]] AffineInvariants find_affine_invariants(const Net& net, TransitionSystem& transition_system,
                                                      const rt::Image& image,
                                                      const std::vector<std::vector<Signal>>& assumed,
                                                      const CancellationToken& cancellation);
/// Returns the candidates, which may come from anywhere, whose sum no step changes. Their totals are not computed.
[[nodiscard]] AffineInvariants equations_that_hold(const Net& net, const TransitionSystem& transition_system,
                                                   const rt::Image& image,
                                                   const std::vector<AffineEquation>& candidates,
                                                   const CancellationToken& cancellation);

/// Returns a row of a certificate: "equation 0 ROOT.m.n*1 ROOT.c@BUSY*-1"
[[nodiscard]] std::string equation_row(const AffineEquation& equation, const System& system);
/// Returns a line for people: "always 0 = m.n - c@BUSY"
[[nodiscard]] std::string equation_text(const AffineEquation& equation, const System& system);

}  // namespace bip::verify
