// What can be stepped from a state on, now or later: each candidate with the instants at which it is one, as the
// published engine lists them. Found by letting time pass to each instant at which something changes, and going back.
//
// For traces that show it, and nothing else: the state, the order from which `uniform` draws included, is as before.
// Cost: the instants at which something changes until time may pass no further, at most kMaxInstants.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "runtime/core/core.hpp"

namespace bip::rt {

struct FutureCandidate {
  std::string text;  // as `tell` gave it when it was first met
  bool is_internal = false;
  InteractionId interaction{0u};
  std::vector<Interval> intervals;  // in their order
};
inline constexpr int kMaxInstants = 1000;

/// In canonical order of the interactions; of one interaction in the order in which they appear. tell(out, core,
/// candidate) appends.
[[nodiscard]] std::vector<FutureCandidate> future_candidates(
    Core& core, const std::function<void(std::string&, Core&, const Candidate&)>& tell);

}  // namespace bip::rt
