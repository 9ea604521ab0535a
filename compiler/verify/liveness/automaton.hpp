// A generalised Büchi automaton that accepts the runs which satisfy a formula of linear temporal logic.
//
// Acceptance is on edges: a run of the automaton accepts if each mark is on infinitely many of its edges. Made by a
// tableau whose states are sets of formulas that the rest of the run has to satisfy (Gerth, Peled, Vardi, Wolper 1995,
// with marks on edges as in Couvreur 1999); then edges that others cover, states from which nothing accepts, states
// that are bisimilar and marks that others imply are removed. Operators that look back are bits of a deterministic
// monitor that runs beside the tableau's automaton (Havelund, Rosu 2002). Size: exponential in the formula in the worst
// case, 2 or 3 states for the usual ones.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/verify/property/formula.hpp"

namespace bip::verify {

struct AutomatonEdge {
  // Of a position: bit k is condition k of the formula's states, then of its steps.
  std::uint64_t required = 0, forbidden = 0;
  std::uint32_t to = 0;
  std::uint32_t marks = 0;  // bit k: the edge has mark k
  friend auto operator<=>(const AutomatonEdge&, const AutomatonEdge&) = default;
};
struct Automaton {
  std::vector<std::vector<AutomatonEdge>> edges;  // by state; the initial one is 0
  std::vector<std::uint8_t> may_accept;           // by state: is it on a cycle with all marks?
  std::uint32_t marks = 0;                        // all of them
  /// Has no run at all that it accepts.
  [[nodiscard]] bool is_empty() const { return edges.empty(); }
  /// Has the state an edge to itself that requires nothing and has all marks?
  [[nodiscard]] bool accepts_whatever_follows(std::uint32_t state) const;
};

/// The bits of the first so many conditions, of which an automaton has 64 at most.
[[nodiscard]] constexpr std::uint64_t first_conditions(std::size_t count) {
  return count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

enum class RunsOf : std::uint8_t { Formula, Negation };
/// Makes the automaton of the runs that satisfy the formula, or its negation. The error says which limit it exceeds.
[[nodiscard]] Result<Automaton> make_automaton(const Formula& formula, RunsOf runs);

}  // namespace bip::verify
