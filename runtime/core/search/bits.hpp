// Sets of leaves as bits: configurations of a plan.
#pragma once
#include <vector>

#include "bip/assert.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

using Bits = std::vector<u64>;

/// Both have the same size.
[[nodiscard]] inline bool contains(const Bits& big, const Bits& small) {
  BIP_ASSERT(big.size() == small.size(), "{} and {} words", big.size(), small.size());
  for (std::size_t i = 0; i < big.size(); ++i) {
    if ((small[i] & ~big[i]) != 0) return false;
  }
  return true;
}

}  // namespace bip::rt
