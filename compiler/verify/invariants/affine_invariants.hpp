// Linear equations between data and places: "requests - 2 * at(clerk.BUSY) = the sum of at(user[i].WAITS)". They hold
// in every stable state, modulo 2^32, as the language's ints do.
//
// A transition, a transfer and an interaction change such a sum by what their code adds (affine_code.hpp) and where
// tokens go; asked that all interactions change it by nothing, one system of homogeneous equations gives all sums
// (sparse_system.hpp). Guards with == are used: "if n == 4 then n is 0" takes 4 away. With them come bounds: an int
// that is a sum of places is as small as that. Cost: linear in the system's code, and what the equations fill. After M.
// Karr (1976); S. Sankaranarayanan, H. Sipma, Z. Manna: Petri Net Analysis Using Invariant Generation (2003).
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

/// An int is never less than 0 and never more than this.
struct VariableBound {
  u32 atom = 0, variable = 0;
  std::int32_t high = 0;
};
struct AffineInvariants {
  std::vector<AffineEquation> equations;
  std::vector<VariableBound> bounds = {};  // true together, with the equations
  std::vector<PlaceValue> places = {};     // none if the equations were found without
};

/// `known`: clauses that hold in every reachable state. The net must be usable.
[[nodiscard]] AffineInvariants find_affine_invariants(const Net& net, TransitionSystem& machine, const rt::Image& image,
                                                      const std::vector<std::vector<Signal>>& known,
                                                      const CancellationToken& cancellation);
/// Those of the candidates, which may come from anywhere, whose sum no step changes; their totals are still to be
/// found.
[[nodiscard]] AffineInvariants equations_that_hold(const Net& net, const TransitionSystem& machine,
                                                   const rt::Image& image,
                                                   const std::vector<AffineEquation>& candidates,
                                                   const CancellationToken& cancellation);
/// Their totals; equations whose first value is not known are left out. And the bounds that the solver shows.
[[nodiscard]] AffineInvariants with_totals(TransitionSystem& machine, const rt::Image& image, AffineInvariants facts);
[[nodiscard]] AffineInvariants with_bounds(const Net& net, TransitionSystem& machine, const rt::Image& image,
                                           const std::vector<std::vector<Signal>>& known,
                                           const CancellationToken& cancellation, AffineInvariants facts);
[[nodiscard]] Signal equation_signal(const AffineEquation& equation, TransitionSystem& machine, const rt::Image& image);
[[nodiscard]] std::vector<Signal> place_clause(const PlaceValue& fact, TransitionSystem& machine,
                                               const rt::Image& image);
[[nodiscard]] Signal bound_signal(const VariableBound& bound, TransitionSystem& machine, const rt::Image& image);

/// "equation 0 ROOT.m.n*1 ROOT.c@BUSY*-1"
[[nodiscard]] std::string equation_row(const AffineEquation& equation, const System& system);
/// "always 0 = m.n - c@BUSY"
[[nodiscard]] std::string equation_text(const AffineEquation& equation, const System& system);

}  // namespace bip::verify
