// The state that the nodes of a distributed run tell the launcher, atom by atom, for a checkpoint and at the end:
// places, data, clocks, actions beside the others, and what goes on with them.
//
// A message may say anything: what cannot be is left out, and take() tells. O(atom) each.
#pragma once
#include <string_view>
#include <vector>

#include "runtime/distributed/checkpoint.hpp"
#include "runtime/distributed/codec.hpp"
#include "runtime/distributed/message.hpp"

namespace bip::rt {

class ToldState {
 public:
  /// All must outlive it.
  ToldState(const Core& core, const Distribution& distribution, const Codec& codec)
      : core_(core), distribution_(distribution), codec_(codec) {}
  /// The initial state, before any step is told.
  void start(const State& initial);
  /// The nodes tell all of it anew.
  void begin() { time_.beside.clear(); }
  /// Of an atom at home at the node (NodeProcess::say_state). False: a part of it cannot be.
  [[nodiscard]] bool take(u32 node, const Control& control);
  /// After so many steps.
  [[nodiscard]] Checkpoint checkpoint(u64 steps) const { return {steps, state_, history_, time_}; }
  /// The state with its time; once, at the end.
  [[nodiscard]] State finish();
  /// Without its time before finish().
  [[nodiscard]] const State& state() const { return state_; }
  /// By atom: an attempt holds it.
  [[nodiscard]] const std::vector<bool>& locked() const { return locked_; }

 private:
  [[nodiscard]] bool take_clocks(u32 atom, std::string_view text);

  const Core& core_;
  const Distribution& distribution_;
  const Codec& codec_;
  State state_;
  std::vector<u32> history_;  // by atom: NextMove::history
  std::vector<bool> locked_;
  SavedTime time_;
};

}  // namespace bip::rt
