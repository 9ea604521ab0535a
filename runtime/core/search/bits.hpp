// Sets of leaves as bits: configurations of a plan.
#pragma once
#include <bit>
#include <cstddef>
#include <set>
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

[[nodiscard]] inline std::size_t size_of(const Bits& bits) {
  std::size_t size = 0;
  for (const u64 word : bits) size += static_cast<std::size_t>(std::popcount(word));
  return size;
}

/// Sets by their sizes. Only a larger one contains another one: of many equally large ones none is compared.
class SetsBySize {
 public:
  void add(const Bits& bits) {
    const std::size_t size = size_of(bits);
    if (by_size_.size() <= size) by_size_.resize(size + 1);
    by_size_[size].insert(bits);
  }
  /// Does one of them contain `bits`? Cost: O(larger ones + log(equally large ones)).
  [[nodiscard]] bool covers(const Bits& bits) const {
    const std::size_t size = size_of(bits);
    return (size < by_size_.size() && by_size_[size].count(bits) != 0) || has_larger(bits, size);
  }
  /// Is `bits` a part of one of them?
  [[nodiscard]] bool has_larger(const Bits& bits) const { return has_larger(bits, size_of(bits)); }

 private:
  [[nodiscard]] bool has_larger(const Bits& bits, std::size_t size) const {
    for (std::size_t larger = size + 1; larger < by_size_.size(); ++larger) {
      for (const Bits& big : by_size_[larger]) {
        if (contains(big, bits)) return true;
      }
    }
    return false;
  }

  std::vector<std::set<Bits>> by_size_;
};

}  // namespace bip::rt
