// Sets of leaves as bits: configurations of a plan.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

using Bits = std::vector<u64>;

/// Both have the same size.
[[nodiscard]] inline bool contains(const Bits& big, const Bits& small) {
  for (std::size_t i = 0; i < big.size(); ++i) {
    if ((small[i] & ~big[i]) != 0) return false;
  }
  return true;
}

}  // namespace bip::rt
