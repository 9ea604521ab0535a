// The members of the list of the enabled set in interaction order, for policies that choose by order while compiled
// steps change the list: a bit by interaction, and above 64 bits one that tells whether any of them is set.
//
// What enters the list is marked, what leaves it is not: a bit without a member is cleared when the search meets it. So
// a step pays for what enters, and a search for what has left since: O(log64 interactions) each, amortised.
#pragma once
#include <bit>
#include <cstdint>
#include <vector>

#include "bip/assert.hpp"
#include "bip/ids.hpp"
#include "bip/steps.hpp"

namespace bip::rt {

class MemberOrder {
 public:
  /// No members among so many interactions.
  void reset(std::uint32_t interactions) {
    size_ = interactions;
    words_.clear();
    levels_ = 0;
    // One word more in each level: a search begins behind the last bit.
    for (std::size_t bits = std::size_t{interactions} + 1;; bits = bits / 64 + 1) {
      BIP_ASSERT(levels_ < kMostLevels, "{} interactions", interactions);
      offset_[levels_++] = words_.size();
      words_.resize(words_.size() + bits / 64 + 2, 0);
      if (bits <= 64) break;
    }
  }
  /// The interaction has entered the list.
  void mark(InteractionId interaction) {
    BIP_ASSERT(interaction.value < size_, "interaction {} of {}", interaction, size_);
    std::size_t at = interaction.value;
    for (std::uint32_t level = 0; level < levels_; ++level, at >>= 6) {
      std::uint64_t& word = words_[offset_[level] + (at >> 6)];
      const bool was_empty = word == 0;
      word |= std::uint64_t{1} << (at & 63);
      if (!was_empty) return;
    }
  }
  /// The first member that is `from` or greater, cyclically. Requires that there is one, and that all are marked.
  [[nodiscard]] InteractionId next(InteractionId from, const std::uint32_t* position) {
    BIP_ASSERT(from.value <= size_, "interaction {} of {}", from, size_);
    std::size_t at = from.value;
    for (;;) {
      at = find(at);
      if (at == kNothing) {
        at = 0;
        continue;
      }
      if (position[at] != kAbsentInteraction) return InteractionId(at);
      clear(at);
    }
  }
  [[nodiscard]] std::size_t bytes() const { return words_.size() * sizeof(std::uint64_t); }

 private:
  static constexpr std::uint32_t kMostLevels = 6;
  static constexpr std::size_t kNothing = ~std::size_t{0};

  // The first bit that is set, `at` or after it.
  [[nodiscard]] std::size_t find(std::size_t at) const {
    for (std::uint32_t level = 0; level < levels_; ++level, at = (at >> 6) + 1) {
      const std::uint64_t word = words_[offset_[level] + (at >> 6)] >> (at & 63);
      if (word == 0) continue;
      at += static_cast<std::size_t>(std::countr_zero(word));
      while (level-- > 0) at = at << 6 | static_cast<std::size_t>(std::countr_zero(words_[offset_[level] + at]));
      return at;
    }
    return kNothing;
  }
  void clear(std::size_t at) {
    for (std::uint32_t level = 0; level < levels_; ++level, at >>= 6) {
      std::uint64_t& word = words_[offset_[level] + (at >> 6)];
      word &= ~(std::uint64_t{1} << (at & 63));
      if (word != 0) return;
    }
  }

  std::vector<std::uint64_t> words_;  // of all levels
  std::size_t offset_[kMostLevels] = {};
  std::uint32_t levels_ = 0;
  std::uint32_t size_ = 0;
};

}  // namespace bip::rt
