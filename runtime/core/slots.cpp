// Packing slots: see slots.hpp. O(slots * log patterns).
#include "runtime/core/slots.hpp"

#include <cstring>

namespace bip::rt {

bool SlotPacker::Less::operator()(u32 a, u32 b) const {
  return std::memcmp(&slots.patterns_[a], &slots.patterns_[b], Slots::kBlock * sizeof(SlotInfo)) < 0;
}

void SlotPacker::add(SlotInfo info) {
  if (slots_.size_ % Slots::kBlock == 0) slots_.blocks_.push_back({static_cast<u32>(slots_.patterns_.size()), info.row, info.first});
  Slots::Block& block = slots_.blocks_.back();
  info.row -= block.row;
  info.first -= block.first;
  slots_.patterns_.push_back(info);
  if (++slots_.size_ % Slots::kBlock != 0) return;
  const auto [same, is_new] = known_.insert(block.pattern);
  if (is_new) return;
  slots_.patterns_.resize(block.pattern);
  block.pattern = *same;
}

void SlotPacker::finish() {
  slots_.blocks_.shrink_to_fit();
  slots_.patterns_.shrink_to_fit();
}

}  // namespace bip::rt
