// Formulas at the points of a run of a model with time (semantics.md, *Points of a run*): a state, or a step that is
// taken from it.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/verify/property/formula.hpp"
#include "runtime/core/core.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::library {

/// Is a node without words of time true at the point? `candidate`: the step; null at a state.
[[nodiscard]] bool is_true_at(const verify::Formula& formula, std::uint32_t row, rt::Core& core,
                              const rt::Candidate* candidate);

/// The monitor of an invariant that looks back (is_invariant_of_past) by `since` and `once` alone: a bit for each of
/// them, set anew at each point (Havelund, Rosu 2002), and one that says that the invariant has been false. The formula
/// must have the type that can_monitor says, and outlive the monitor. Cost of a point: linear in the formula.
[[nodiscard]] rt::TimedMonitor monitor_of(const verify::Formula& formula);
/// Has it neither `previously`, which is about the point before, nor more than 63 words that look back?
[[nodiscard]] bool can_monitor(const verify::Formula& formula);

}  // namespace bip::library
