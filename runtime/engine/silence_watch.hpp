// Which nodes of a distributed run give no sign. The launcher sends each node a beat once a second, and a node answers
// it between two steps: silence is an action that takes long, a process that is stopped, or a host that is out of
// reach.
//
// While the launcher itself is stopped (Ctrl-Z, output that blocks) it receives nothing: when it goes on, it counts the
// silence of nodes from that moment. This file has no input, output or clock.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

inline constexpr i64 kBeat = 1000000000;  // ns between beats
inline constexpr i64 kMostMissed = 3;     // missed beats until silence is reported

enum class Sign : std::uint8_t {
  Same,    // nothing to report
  Silent,  // for kMostMissed beats
  Heard,   // after a silence that was reported
  Lost     // silent for longer than it may be
};

class SilenceWatch {
 public:
  /// Of so many nodes, from `now` on, in ns.
  SilenceWatch(u32 nodes, i64 now) : is_silent_(nodes, false), since_(now), looked_at_(now) {}

  /// Before the signs of an instant are asked for. Requires: at most a beat after the last time, if this process ran.
  void begin_look(i64 now) {
    if (now - looked_at_ > 2 * kBeat) since_ = now;
    looked_at_ = now;
  }
  /// ns since the node was last heard, at `heard` (0: never).
  [[nodiscard]] i64 silence(i64 heard) const { return looked_at_ - (heard > since_ ? heard : since_); }
  /// lost_after: ns; kForever for a node whose process the launcher watches.
  [[nodiscard]] Sign sign(u32 node, i64 heard, i64 lost_after) {
    const i64 silent_for = silence(heard);
    if (silent_for >= lost_after) return Sign::Lost;
    if (silent_for >= kMostMissed * kBeat && !is_silent_[node]) {
      is_silent_[node] = true;
      return Sign::Silent;
    }
    if (silent_for < 2 * kBeat && is_silent_[node] && heard > since_) {
      is_silent_[node] = false;
      return Sign::Heard;
    }
    return Sign::Same;
  }

 private:
  std::vector<bool> is_silent_;  // by node, and that was reported
  i64 since_, looked_at_;
};

}  // namespace bip::rt
