// Weights of candidates: how likely the policy `uniform` draws each beside the others (semantics.md, Weights).
//
// The weight of a candidate is that of its connector times those of the transitions that it fires. Models without
// weights have empty tables, and nothing asks.
#pragma once
#include <vector>

#include "runtime/core/fire/firing.hpp"
#include "runtime/core/state/enabled_set.hpp"

namespace bip::rt {

struct CoreParts;

class CandidateWeights {
 public:
  explicit CandidateWeights(CoreParts& core) : core_(core) {}
  /// O(weights + transitions of all types + connectors) if there are weights.
  void link();

  [[nodiscard]] bool any() const { return !of_transition_.empty(); }
  /// Returns the weight of a candidate, above 0. Requires any(). O(participants).
  [[nodiscard]] double weight(EnabledSet::Position at);
  /// Returns one of the candidates, drawn by weights: `share` of the way through all of them in canonical order, 0 <=
  /// share < 1. Requires any(), and a candidate. O(candidates * participants).
  [[nodiscard]] EnabledSet::Position drawn(double share);

 private:
  struct Row {
    double value = 1;
    u32 param = kNone;
  };
  CoreParts& core_;
  std::vector<Row> of_transition_;    // by linked transition; empty: the image has no weights
  std::vector<double> of_connector_;  // by connector
  std::vector<Participant> participants_;
  std::vector<double> weights_;  // scratch of `drawn`
};

}  // namespace bip::rt
