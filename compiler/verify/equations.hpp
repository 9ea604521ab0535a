// Linear equations between data and places: "requests - 2 * at(clerk.BUSY) = the sum of at(user[i].WAITS)". They hold in every stable
// state, modulo 2^32, as the language's ints do.
//
// A transition, a transfer and an interaction change such a sum by what their code adds (affine.hpp) and where tokens go; asked that all
// interactions change it by nothing, one system of homogeneous equations gives all sums (sparse_system.hpp). Guards with == are used:
// "if n == 4 then n is 0" takes 4 away. With them come bounds: an int that is a sum of places is as small as that. Cost: linear in the system's code, and what the equations fill.
// After M. Karr (1976); S. Sankaranarayanan, H. Sipma, Z. Manna: Petri Net Analysis Using Invariant Generation (2003).
#pragma once
#include <string>

#include "compiler/verify/machine.hpp"
#include "compiler/verify/place_values.hpp"
#include "compiler/verify/prove.hpp"

namespace bip::verify {

struct LinearEquation {
  struct Term {
    u32 atom = 0, row = 0;  // place or slot of its type
    bool is_place = false;
    std::int32_t weight = 0;
    friend auto operator<=>(const Term&, const Term&) = default;
  };
  std::vector<Term> terms;
  std::int32_t total = 0;
};

/// An int is never less than 0 and never more than this.
struct SlotBound {
  u32 atom = 0, slot = 0;
  std::int32_t high = 0;
};
struct LinearFacts {
  std::vector<LinearEquation> equations;
  std::vector<SlotBound> bounds = {};   // true together, with the equations
  std::vector<PlaceValue> places = {};  // none if the equations were found without
};

/// `known`: clauses that hold in every reachable state. The net must be usable.
[[nodiscard]] LinearFacts find_linear_facts(const Net& net, Machine& machine, const rt::Image& image, const std::vector<std::vector<Signal>>& known,
                                            ProcessClock::time_point end);
/// Those of the candidates, which may come from anywhere, whose sum no step changes; their totals are still to be found.
[[nodiscard]] LinearFacts equations_that_hold(const Net& net, const Machine& machine, const rt::Image& image, const std::vector<LinearEquation>& candidates,
                                                              ProcessClock::time_point end);
/// Their totals; equations whose first value is not known are left out. And the bounds that the solver shows.
[[nodiscard]] LinearFacts with_totals(Machine& machine, const rt::Image& image, LinearFacts facts);
[[nodiscard]] LinearFacts with_bounds(const Net& net, Machine& machine, const rt::Image& image, const std::vector<std::vector<Signal>>& known, ProcessClock::time_point end,
                                      LinearFacts facts);
[[nodiscard]] Signal equation_signal(const LinearEquation& equation, Machine& machine, const rt::Image& image);
[[nodiscard]] std::vector<Signal> place_clause(const PlaceValue& fact, Machine& machine, const rt::Image& image);
[[nodiscard]] Signal bound_signal(const SlotBound& bound, Machine& machine, const rt::Image& image);

/// "equation 0 ROOT.m.n*1 ROOT.c@BUSY*-1"
[[nodiscard]] std::string equation_row(const LinearEquation& equation, const System& system);
/// "always 0 = m.n - c@BUSY"
[[nodiscard]] std::string equation_text(const LinearEquation& equation, const System& system);

}  // namespace bip::verify
