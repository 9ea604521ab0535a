// Lowers the guard and the `up` of a clause to operations over intervals (runtime/core/search/ranges.hpp).
#pragma once
#include <optional>
#include <vector>

#include "compiler/model/types.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::lower {

struct ClauseRanges {
  std::vector<rt::RangeOp> guard, up;
};
/// nullopt if running the code has effects that ranges do not show: a fault, a call of C++, or a write to what is
/// bound. Operations on values of which ranges cannot tell (strings, bits, quotients) become Any. Linear in the code.
[[nodiscard]] std::optional<ClauseRanges> clause_ranges(const CodeTable& code, const Clause& clause);

}  // namespace bip::lower
