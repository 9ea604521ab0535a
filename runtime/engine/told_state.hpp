// Collects the state of a distributed run. For a checkpoint, and at the end of the run, each node sends the launcher
// one message for each atom at home there: its place, its data, its clocks, its action that runs beside the others
// (`@async`), and whether an attempt holds it (node_locks.cpp).
//
// Messages are not trusted. take() refuses a malformed one, and of others it leaves out a place or a history that the
// model does not have. Cost of a message: linear in the variables and clocks of its atom.
#pragma once
#include <string_view>
#include <vector>

#include "runtime/distributed/checkpoint.hpp"
#include "runtime/distributed/codec.hpp"
#include "runtime/distributed/message.hpp"

namespace bip::rt {

class ToldState {
 public:
  /// The arguments must outlive this object.
  ToldState(const Core& core, const Distribution& distribution, const Codec& codec)
      : core_(core), distribution_(distribution), codec_(codec) {}
  /// Takes the initial state. An atom whose home sends nothing, because it is lost, keeps what was sent last, or this.
  void start(const State& initial);
  /// Prepares for a new message of each atom, for the next checkpoint or the end.
  void begin() { time_.beside.clear(); }
  /// Takes the message of an atom (Control::Kind::Atom, made by NodeProcess::say_state). Returns false if it is
  /// malformed, or if the atom is not at home at the node.
  [[nodiscard]] bool take(u32 node, const Control& control);
  /// Returns the state that the nodes sent last, as a checkpoint after `steps` steps.
  [[nodiscard]] Checkpoint checkpoint(u64 steps) const { return {steps, state_, history_, time_}; }
  /// Returns the state that the nodes sent last, with its clocks and actions. Requires that it is called once.
  [[nodiscard]] State finish();
  /// The state that the nodes sent last; its clocks and actions are part of it after finish() only.
  [[nodiscard]] const State& state() const { return state_; }
  /// By atom: does an attempt hold it?
  [[nodiscard]] const std::vector<bool>& locked() const { return locked_; }

 private:
  [[nodiscard]] bool take_clocks(u32 atom, std::string_view text);

  const Core& core_;
  const Distribution& distribution_;
  const Codec& codec_;
  State state_;
  std::vector<u32> history_;  // by atom: the last interaction that tells what may come next (NextMove::history)
  std::vector<bool> locked_;
  SavedTime time_;
};

}  // namespace bip::rt
