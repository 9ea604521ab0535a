// The report of a distributed run that lost nodes: which nodes, which components were at home there, which wait for
// them.
#pragma once
#include <string>
#include <vector>

#include "runtime/core/core.hpp"
#include "runtime/distributed/distribution.hpp"

namespace bip::rt {

/// What goes on without the lost nodes. Linear in the ports of all interactions and groups. Constant.
class Survivors {
 public:
  /// The core and the distribution must outlive it.
  Survivors(const Core& core, const Distribution& distribution, std::vector<bool> is_lost);

  [[nodiscard]] bool is_lost(u32 node) const { return is_lost_[node]; }
  /// Are its coordinator there, and the homes of all that take part in it or that it looks at?
  [[nodiscard]] bool is_whole(InteractionId interaction) const { return is_whole_[interaction]; }
  /// Is there an interaction that can take the atom, from any place, and that is not whole?
  [[nodiscard]] bool may_wait(u32 atom) const;
  /// Can interactions take the atom from this place (of Petri types: at all), and is none of them whole?
  [[nodiscard]] bool waits(u32 atom, u32 place) const;

 private:
  const Core& core_;
  std::vector<bool> is_lost_;
  IndexVector<InteractionId, bool> is_whole_;
  InteractionsBy interactions_of_atom_;
};

/// Several lines. `core` is in the last state, as far as it is known. locked: by atom: an attempt that has ended
/// nowhere holds it; empty: none. `why`: how the nodes ended; may be empty.
[[nodiscard]] std::string loss_story(const Core& core, const Distribution& distribution, const Survivors& survivors,
                                     const std::vector<bool>& locked, u64 steps, const std::string& why);

/// Two lines: which components are at home on the node, and which of other nodes take part in interactions that need
/// it.
[[nodiscard]] std::string silence_story(const Core& core, const Distribution& distribution, u32 node);

}  // namespace bip::rt
