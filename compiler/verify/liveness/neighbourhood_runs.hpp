// Proves a property of runs by neighbourhoods: what one or two components do beside those that the property names,
// value by value, everything else being free to do what it likes.
//
// A run that violates the property goes, from some point on, round one strong component of the product of the negated
// property's automaton with the named components: a case. In a case steps are found to be finite, taken finitely often:
// first those of the named components that are on no edge of the strong component, then, with one or two other
// components beside, those on no cycle that is fair and takes no finite step. In a lock, say, process 0 waits at level
// 3 for ever. If another process entered level 3 twice, process 0 would go on in between; so each of them enters it
// once at most, and passes it once. A case is refuted if some neighbourhood has no cycle left: where all steps outside
// of it are finite, too, its own must go on, or the run ends. Without time, C++ or connectors other than plain
// rendezvous. Sound and incomplete.
//
// A. Cohen, K. Namjoshi: Local Proofs for Linear-Time Properties of Concurrent Programs (CAV 2008); the order in which
// steps are found to be finite: Z. Manna, A. Pnueli, Completing the Temporal Picture (1991). Cost: for each case and
// neighbourhood the tuples of local states, times the steps of these components; no search of the whole.
#pragma once
#include <cstdint>
#include <functional>

#include "compiler/system/system.hpp"
#include "compiler/verify/property/fairness.hpp"
#include "compiler/verify/property/formula.hpp"
#include "compiler/verify/solver/cancellation.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::verify {

struct NeighbourhoodProof {
  bool is_proved = false;
  std::uint32_t cases = 0;          // that were refuted
  std::uint32_t neighbours = 0;     // most components beside the named ones at a time
  bool needs_endless_runs = false;  // the proof rests on it that no run ends
  bool may_have_errors = false;     // some step may end in a run-time error
};

struct NeighbourhoodOptions {
  Fairness fairness;
  CancellationToken cancellation;
  /// Does no run end? Asked at most once, if a case needs it; false: not known.
  std::function<bool()> never_ends;
};

/// Can neighbourhoods say anything about such a system? Linear.
[[nodiscard]] bool has_neighbourhoods(const System& system, const rt::Image& image);

/// Requires has_neighbourhoods(); `system` and `image` are of one compilation, without a fault in the initialization.
[[nodiscard]] NeighbourhoodProof prove_by_neighbourhoods(const Formula& formula, const System& system,
                                                         const rt::Image& image, const NeighbourhoodOptions& options);

}  // namespace bip::verify
