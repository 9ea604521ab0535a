// The steps of several nodes in one order: those of smaller numbers first. A step is written when no node can tell of
// an earlier one any more and all of its parts have ended.
//
// O(log steps that are not written) a step.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/core/core.hpp"
#include "runtime/distributed/distribution.hpp"
#include "runtime/distributed/message.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/engine/step_follower.hpp"
#include "runtime/engine/unwritten_steps.hpp"

namespace bip::rt {

class StepMerge {
 public:
  StepMerge(Core& core, const Distribution& distribution, Output& output)
      : core_(core),
        distribution_(distribution),
        output_(output),
        bounds_(distribution.placement.nodes.size(), 0),
        is_lost_(bounds_.size(), false) {}

  /// Makes what is written about steps here, from `initial` on, where nodes send no texts (can_follow_steps). Before
  /// the first step.
  void follow(const State& initial) { follower_.emplace(core_, initial); }
  /// False: a step that was to be written is none of the model, or comes after one with a fault.
  [[nodiscard]] bool is_sound() const { return is_sound_; }
  /// The step that was written last ended in a run-time error, whether its node told of it or not.
  [[nodiscard]] bool has_met_fault() const { return follower_ && follower_->has_met_fault(); }
  /// Control::Kind::Begun of a node. False: it is none.
  bool take_begun(u32 node, const Control& control);
  /// Control::Kind::Took of a node. Returns how many steps; 0: it is none.
  u64 take_many(u32 node, const Control& control);
  /// Control::Kind::Fired of a node. Returns how many steps; 0: it is none, or not of this run.
  u64 take_fired(u32 node, const Control& control);
  void take_landed(u32 node, const std::vector<u64>& steps);
  /// The node will tell of no step up to this one any more.
  void raise_bound(u32 node, u64 step) { bounds_[node] = std::max(bounds_[node], step); }
  [[nodiscard]] u64 bound(u32 node) const { return bounds_[node]; }
  /// Parts of steps that the node has not reported stay open.
  void lose(u32 node) { is_lost_[node] = true; }
  void write_ready();
  /// Up to this step, whether its parts have ended or not.
  void write_until(u64 step);
  [[nodiscard]] u64 written() const { return written_; }
  [[nodiscard]] std::size_t waiting() const { return flights_.size(); }
  /// Of those that are not written: bytes (record_bytes), now and at most so far.
  [[nodiscard]] u64 waiting_bytes() const { return waiting_bytes_; }
  [[nodiscard]] u64 most_waiting_bytes() const { return most_waiting_bytes_; }
  /// Of those that are written.
  [[nodiscard]] u64 written_bytes() const { return written_bytes_; }
  /// The last one that is written; 0: none is.
  [[nodiscard]] u64 last_written() const { return last_written_; }
  /// The first one that is not written. Requires that there is one.
  [[nodiscard]] u64 first_waiting() const { return flights_.begin()->first; }

 private:
  struct Step {
    InteractionId interaction;
    u32 rank = 0;                          // of its candidate; known if steps are followed
    u64 out_number = 0, trace_number = 0;  // 1 + where it belongs in the text; 0: nowhere
    u64 out_size = 0, trace_size = 0;      // of its text
  };
  // Steps with one number: one, or several of a node.
  struct Flight {
    bool is_told = false;
    std::vector<Step> steps;
    StepText text;                          // of all
    std::vector<std::pair<u32, int>> open;  // node, parts there that have not ended
    std::vector<InteractionId> fired;       // of all, if nothing else is written; then there are no steps and no text
    [[nodiscard]] u64 bytes() const {
      return fired.empty() ? record_bytes(text, steps.size()) : fired_bytes(fired.size());
    }
  };
  static void add(Flight& flight, u32 node, int parts);
  [[nodiscard]] bool has_ended(const Flight& flight) const;
  [[nodiscard]] bool is_step(const Step& step) const;
  void add_waiting(const Flight& flight);
  [[nodiscard]] bool is_new(u32 node, u64 number) const;
  void write_first();
  void write_texts(const Flight& flight, const std::string& node);
  void write_followed(EnabledSet::Position at, const std::string& node);

  Core& core_;
  const Distribution& distribution_;
  Output& output_;
  std::vector<u64> bounds_;  // by node
  std::vector<bool> is_lost_;
  std::map<u64, Flight> flights_;
  std::optional<StepFollower> follower_;
  StepText text_;  // scratch
  bool is_sound_ = true;
  u64 written_ = 0, last_written_ = 0;
  u64 waiting_bytes_ = 0, most_waiting_bytes_ = 0, written_bytes_ = 0;
};

}  // namespace bip::rt
