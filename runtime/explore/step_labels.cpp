// See step_labels.hpp.
#include "runtime/explore/step_labels.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/explore/word_set.hpp"

namespace bip::rt {

u32 StepLabels::of(Core& core, const Candidate& candidate) {
  participants_.clear();
  core.participants(candidate, participants_);
  wanted_.clear();
  for (const Participant& participant : participants_) wanted_.push_back({participant.atom, participant.port});
  return find_or_add(candidate.interaction, candidate.connector);
}

u32 StepLabels::of(InteractionId interaction, u32 connector, Span<InteractionLeaf> leaves) {
  wanted_.clear();
  for (const InteractionLeaf& leaf : leaves) wanted_.push_back({leaf.atom, leaf.port});
  return find_or_add(interaction, connector);
}

bool StepLabels::has_port(u32 label, PortOfAtom port) const {
  const Span<PortOfAtom> all = ports(label);
  return std::find(all.begin(), all.end(), port) != all.end();
}

u32 StepLabels::find_or_add(InteractionId interaction, u32 connector) {
  std::sort(wanted_.begin(), wanted_.end(), [](const PortOfAtom& a, const PortOfAtom& b) {
    return a.atom != b.atom ? a.atom < b.atom : a.port < b.port;
  });
  u64 hash = WordSet::hash_of(interaction.value);
  for (const PortOfAtom& port : wanted_) hash = WordSet::hash_of(hash ^ (u64{port.atom} << 32 | port.port));
  const auto [begin, end] = rows_.equal_range(hash);
  for (auto at = begin; at != end; ++at) {
    const Span<PortOfAtom> all = ports(at->second);
    if (labels_[at->second].interaction == interaction &&
        std::equal(all.begin(), all.end(), wanted_.begin(), wanted_.end()))
      return at->second;
  }
  const u32 row = size();
  labels_.push_back({interaction, connector, static_cast<u32>(ports_.size()), static_cast<u32>(wanted_.size())});
  ports_.insert(ports_.end(), wanted_.begin(), wanted_.end());
  rows_.emplace(hash, row);
  return row;
}

}  // namespace bip::rt
