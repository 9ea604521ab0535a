// The enabled set: how many candidates each slot has, in slot order. A bitset with a tree of counts of fan-out 8 above
// it, so that "the k-th candidate" and "how many before slot s" cost O(log n) and an update costs one addition a level.
// Choices are random, so the descent has no branch that depends on them.
//
// Most systems have at most one candidate a slot; only `weighted` sets keep a weight a slot.
#pragma once
#include <bit>
#include <cstdint>
#include <vector>

namespace bip::rt {

class EnabledSet {
 public:
  void reset(std::uint32_t slots, bool weighted) {
    words_.assign(static_cast<std::size_t>(slots) / 64 + 1, 0);
    weights_.assign(weighted ? slots : 0, 0);
    counts_.clear();
    levels_ = 0;
    for (std::size_t entries = words_.size(); entries > 1; entries = (entries + 7) / 8) {
      offset_[levels_++] = static_cast<std::uint32_t>(counts_.size());
      // Padded to whole groups of 8, so that a scan of a group never leaves the level.
      counts_.resize(counts_.size() + (entries + 7) / 8 * 8, 0);
      if (entries <= 8) break;
    }
    total_ = 0;
  }

  [[nodiscard]] std::uint64_t total() const { return total_; }
  [[nodiscard]] std::uint32_t weight(std::uint32_t slot) const {
    if (!weights_.empty()) return weights_[slot];
    return static_cast<std::uint32_t>(words_[slot >> 6] >> (slot & 63) & 1);
  }

  /// Unweighted sets. The slot must not be in the set.
  void insert(std::uint32_t slot) {
    words_[slot >> 6] |= std::uint64_t{1} << (slot & 63);
    add(slot, 1);
  }
  /// Unweighted sets. The slot must be in the set.
  void erase(std::uint32_t slot) {
    words_[slot >> 6] &= ~(std::uint64_t{1} << (slot & 63));
    add(slot, ~0u);
  }
  /// Unweighted sets. The slot is in the set iff its counter is not negative; the counter changed. Free of branches.
  void follow(std::uint32_t slot, std::int32_t before, std::int32_t after) {
    const auto was = static_cast<std::uint32_t>(before) >> 31, is = static_cast<std::uint32_t>(after) >> 31;
    words_[slot >> 6] ^= std::uint64_t{was ^ is} << (slot & 63);
    add(slot, was - is);
  }
  void set(std::uint32_t slot, std::uint32_t weight_now) {
    const std::uint32_t before = weight(slot);
    if (before == weight_now) return;
    const std::uint64_t bit = std::uint64_t{1} << (slot & 63);
    if (weight_now != 0) words_[slot >> 6] |= bit; else words_[slot >> 6] &= ~bit;
    if (!weights_.empty()) weights_[slot] = weight_now;
    add(slot, weight_now - before);
  }

  struct Position {
    std::uint32_t slot;
    std::uint32_t rank;  // among the slot's candidates
  };
  /// The k-th candidate, k < total().
  [[nodiscard]] Position select(std::uint64_t k) const {
    auto left = static_cast<std::uint32_t>(k);
    std::size_t entry = 0;
    for (std::uint32_t level = levels_; level-- > 0;) {
      const std::uint32_t* counts = counts_.data() + offset_[level] + entry * 8;
      std::uint32_t sum = 0, before = 0, skipped = 0;
      for (int i = 0; i < 7; ++i) {
        sum += counts[i];
        const std::uint32_t passed = sum <= left ? 1 : 0;
        skipped += passed;
        before = passed != 0 ? sum : before;
      }
      left -= before;
      entry = entry * 8 + skipped;
    }
    std::uint64_t word = words_[entry];
    if (weights_.empty()) return {static_cast<std::uint32_t>(entry * 64) + select_bit(word, left), 0};
    for (;; word &= word - 1) {
      const std::uint32_t slot = static_cast<std::uint32_t>(entry * 64) + static_cast<std::uint32_t>(std::countr_zero(word));
      if (left < weights_[slot]) return {slot, left};
      left -= weights_[slot];
    }
  }
  /// The number of candidates in slots below `slot`.
  [[nodiscard]] std::uint64_t rank(std::uint32_t slot) const {
    std::uint64_t sum = 0;
    std::size_t entry = slot >> 6;
    std::uint64_t word = words_[entry] & ((std::uint64_t{1} << (slot & 63)) - 1);
    if (weights_.empty()) {
      sum = count_bits(word);
    } else {
      for (; word != 0; word &= word - 1) sum += weights_[entry * 64 + static_cast<std::size_t>(std::countr_zero(word))];
    }
    for (std::uint32_t level = 0; level < levels_; ++level) {
      for (std::size_t i = entry / 8 * 8; i < entry; ++i) sum += counts_[offset_[level] + i];
      entry /= 8;
    }
    return sum;
  }

 private:
  // Without -mpopcnt std::popcount is a call; this is a dozen instructions.
  static std::uint32_t count_bits(std::uint64_t x) {
    x -= x >> 1 & 0x5555555555555555u;
    x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return static_cast<std::uint32_t>(x * 0x0101010101010101u >> 56);
  }
  // The position of the k-th one (Vigna, "Broadword implementation of rank/select queries", 2008, to the byte).
  static std::uint32_t select_bit(std::uint64_t word, std::uint32_t k) {
    constexpr std::uint64_t kOnes = 0x0101010101010101u;
    std::uint64_t sums = word - (word >> 1 & 0x5555555555555555u);
    sums = (sums & 0x3333333333333333u) + (sums >> 2 & 0x3333333333333333u);
    sums = ((sums + (sums >> 4)) & 0x0f0f0f0f0f0f0f0fu) * kOnes;
    const std::uint64_t not_above = ((k * kOnes | kOnes << 7) - sums) & kOnes << 7;
    const auto place = static_cast<std::uint32_t>((not_above >> 7) * kOnes >> 56) * 8;
    std::uint32_t left = k - static_cast<std::uint32_t>((sums << 8) >> place & 0xff);
    word >>= place;
    for (; left > 0; --left) word &= word - 1;
    return place + static_cast<std::uint32_t>(std::countr_zero(word));
  }
  void add(std::uint32_t slot, std::uint32_t difference) {
    total_ += difference;
    std::uint32_t entry = slot >> 6;
    for (std::uint32_t level = 0; level < levels_; ++level, entry >>= 3) counts_[offset_[level] + entry] += difference;
  }

  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> weights_;
  std::vector<std::uint32_t> counts_;
  std::uint32_t offset_[12] = {};
  std::uint32_t levels_ = 0;
  std::uint32_t total_ = 0;
};

}  // namespace bip::rt
