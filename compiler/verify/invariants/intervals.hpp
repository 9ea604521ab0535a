// Between which numbers each variable of the system stays, whatever is done: intervals over all atoms and connectors at
// once, not by place. Guards narrow what actions and transfers see. Bools count as 0 and 1, strings as their rows.
//
// A fixpoint from the initial values up; what goes on growing jumps to the next constant of the code, then to the end
// of int. Cost: a few passes over the code of all instances. P. Cousot, R. Cousot: Static Determination of Dynamic
// Properties of Programs (1976).
#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::verify {

struct Range {
  std::int64_t low = 0, high = 0;
  [[nodiscard]] bool is_empty() const { return low > high; }
  friend bool operator==(const Range&, const Range&) = default;
};
inline constexpr Range kAnyInt{std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()};

/// By row among all variables of the image (atoms', then connectors' own). Of floats and FFI values: meaningless.
[[nodiscard]] std::vector<Range> find_ranges(const System& system, const rt::Image& image);

}  // namespace bip::verify
