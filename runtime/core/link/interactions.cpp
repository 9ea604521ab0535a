// Packing interactions: see interactions.hpp. O(interactions * log patterns).
#include "runtime/core/link/interactions.hpp"

#include <cstring>

namespace bip::rt {

bool InteractionPacker::Less::operator()(u32 a, u32 b) const {
  return std::memcmp(&interactions.patterns_[a], &interactions.patterns_[b],
                     Interactions::kBlock * sizeof(InteractionInfo)) < 0;
}

void InteractionPacker::add(InteractionInfo info) {
  BIP_ASSERT(info.count <= InteractionInfo::kMostPorts, "{} ports", u32{info.count});
  if (interactions_.size_ % Interactions::kBlock == 0)
    interactions_.blocks_.push_back({static_cast<u32>(interactions_.patterns_.size()), info.row, info.first});
  Interactions::Block& block = interactions_.blocks_.back();
  info.row -= block.row;
  info.first -= block.first;
  interactions_.patterns_.push_back(info);
  if (++interactions_.size_ % Interactions::kBlock != 0) return;
  const auto [same, is_new] = known_.insert(block.pattern);
  if (is_new) return;
  interactions_.patterns_.resize(block.pattern);
  block.pattern = *same;
}

void InteractionPacker::finish() {
  interactions_.blocks_.shrink_to_fit();
  interactions_.patterns_.shrink_to_fit();
}

}  // namespace bip::rt
