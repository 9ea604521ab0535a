// What a step is, as a number: the interaction that happens, that is a connector and the ports of atoms that take part.
//
// A connector with triggers has one label for each set of ports that was met. Candidates of one connector that differ
// only in their data have the same label. Labels are numbered as they are met. Not thread-safe. Cost: one look-up in a
// hash table; the ports are found by the core.
#pragma once
#include <unordered_map>
#include <vector>

#include "runtime/core/core.hpp"
#include "runtime/explore/shapes.hpp"

namespace bip::rt {

struct PortOfAtom {
  u32 atom, port;
  friend bool operator==(const PortOfAtom&, const PortOfAtom&) = default;
};
struct StepLabel {
  InteractionId interaction{0u};  // of the candidate order
  u32 connector = kNone;          // kNone: an internal port
  u32 first = 0, count = 0;       // ports, sorted
};

class StepLabels {
 public:
  /// The label of a candidate of the state that the core is in.
  u32 of(Core& core, const Candidate& candidate);
  /// The label of an interaction in which all its leaves take part.
  u32 of(InteractionId interaction, u32 connector, Span<InteractionLeaf> leaves);

  [[nodiscard]] u32 size() const { return static_cast<u32>(labels_.size()); }
  [[nodiscard]] const StepLabel& operator[](u32 label) const { return labels_[label]; }
  [[nodiscard]] Span<PortOfAtom> ports(u32 label) const {
    return {ports_.data() + labels_[label].first, labels_[label].count};
  }
  [[nodiscard]] bool has_port(u32 label, PortOfAtom port) const;

 private:
  u32 find_or_add(InteractionId interaction, u32 connector);

  std::vector<StepLabel> labels_;
  std::vector<PortOfAtom> ports_;
  std::unordered_multimap<u64, u32> rows_;  // by hash
  std::vector<Participant> participants_;   // scratch
  std::vector<PortOfAtom> wanted_;
};

}  // namespace bip::rt
