// Monotone propagation in the net. A mode is switched on; a move is ready if the mode at one of its ends is on; a port
// is ready if a move of it is; a step is ready if all its ports are. A move that takes part in a ready step switches on
// the mode at its other end. Both fixpoints of the prover are this:
//
//   Forward   on = reachable. A move is ready if its source is on, and switches on its target.
//   Backward  on = not in the trap. A move is ready if its target is on; with all others in the step ready, nothing
//             would be put into the set, so its source must not be in the set either.
//
// Steps are decided by structure: `is_ready(node)`: some choice below is; `in_context(node)`: what else the step needs
// is. Cost: linear in the net (each group is scanned at most three times).
#pragma once
#include <vector>

#include "compiler/verify/net/net.hpp"

namespace bip::verify {

enum class Direction : std::uint8_t { Forward, Backward };

class ModeReachability {
 public:
  /// Backward only follows moves that `forward` found possible; it may be null.
  ModeReachability(const Net& net, Direction direction, const ModeReachability* forward);

  void turn_on(u32 mode);
  /// To the fixpoint.
  void run();

  [[nodiscard]] bool is_on(u32 mode) const { return on_[mode] != 0; }
  /// Forward: the port takes part in some reachable step's choice, as far as this abstraction sees.
  [[nodiscard]] bool in_context(u32 port) const { return context_[port] != 0; }

 private:
  [[nodiscard]] bool is_possible(u32 port, u32 from_mode) const {
    return forward_ == nullptr || (forward_->is_on(from_mode) && forward_->in_context(port));
  }
  void make_ready(u32 node);
  void put_in_context(u32 node);
  void spread_context(u32 group);
  void fire_port(u32 port);
  [[nodiscard]] bool is_closed() const;

  const Net& net_;
  Direction direction_;
  const ModeReachability* forward_;
  std::vector<std::uint8_t> on_;               // by mode
  std::vector<std::uint8_t> ready_, context_;  // by node
  std::vector<u32> count_;                     // All: children not ready; Trigger: ready triggers
  std::vector<u32> mode_todo_, ready_todo_, context_todo_;
};

}  // namespace bip::verify
