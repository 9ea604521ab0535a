// Interval analysis: bounds each variable of the system in all reachable states, over all atoms and connectors at once
// and not by place. Guards refine what actions and transfers read. Bools count as 0 and 1, strings as their rows.
//
// P. Cousot, R. Cousot: Static Determination of Dynamic Properties of Programs (1976). A least fixpoint from the
// initial values with widening to thresholds: a bound that goes on growing jumps to the next constant of the code, then
// to the end of int. No narrowing. Cost: a few passes over the code of all instances.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/system/system_ids.hpp"
#include "compiler/verify/invariants/interval_domain.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::verify {

/// Returns the range of each variable, by row among all variables of the image (atoms', then connectors' own). Ranges
/// of floats and FFI values have no meaning. `is_free`: by row, variables that may have any value of their type at any
/// time; empty: none.
[[nodiscard]] std::vector<Range> find_ranges(const System& system, const rt::Image& image,
                                             const std::vector<std::uint8_t>& is_free = {});

}  // namespace bip::verify
