// The interactions fired last, a ring: for explanations and for traces of compiled steps. No part of the state.
#pragma once
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "bip/assert.hpp"
#include "bip/steps.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

class FiringHistory {
 public:
  static constexpr u32 kSize = StepHistory::kSize;

  void reset() {
    ring_.assign(kSize, kNone);
    at_ = 0;
  }
  void remember(InteractionId interaction) { ring_[std::exchange(at_, (at_ + 1) % kSize)] = interaction.value; }
  /// Returns the last `count` interactions, at most kSize of them, in the order of their firing.
  [[nodiscard]] std::vector<InteractionId> recent(u64 count) const;
  /// Calls `take` with the same as rows: with one or two pieces of the ring. O(1) but for what `take` costs.
  template <class Take>
  void visit_recent(u64 count, Take take) const {
    BIP_ASSERT(count <= kSize, "{} of the last {} interactions", count, kSize);
    const u32 first = (at_ + kSize - static_cast<u32>(count)) % kSize;
    const u32 until_end = std::min(static_cast<u32>(count), kSize - first);
    take(std::span<const u32>(ring_).subspan(first, until_end));
    if (count != until_end) take(std::span<const u32>(ring_).first(count - until_end));
  }
  /// The k-th before the one that fired last, k < kSize; of those that fired.
  [[nodiscard]] InteractionId before_last(u64 k) const {
    return InteractionId(ring_[(at_ + kSize - 1 - static_cast<u32>(k)) % kSize]);
  }
  /// Returns by atom the interaction of the last step in which it may have taken part; none: not known.
  [[nodiscard]] std::vector<InteractionId> last_of_atoms(const Tables& tables) const;

  // ---- for loops that keep the ring in registers (compiled_steps.cpp)
  [[nodiscard]] u32* ring() { return ring_.data(); }
  [[nodiscard]] u32 next() const { return at_; }
  void set_next(u32 at) { at_ = at; }
  /// Forgets what was fired.
  void clear() { std::fill(ring_.begin(), ring_.end(), kNone); }
  [[nodiscard]] std::size_t bytes() const { return ring_.size() * sizeof(u32); }

 private:
  std::vector<u32> ring_;  // interactions as plain numbers, for compiled steps write them; kNone: none yet
  u32 at_ = 0;             // where the next one goes
};

}  // namespace bip::rt
