// Merges the steps that nodes report into one sequence, which the launcher writes to the step lines and the trace.
//
// Each step has a number, made of the clock of the node that began it and of that node's row (step_at), and steps are
// written by ascending numbers. A step waits until two things hold: no node can report a step with a smaller number any
// more (each node has reported a larger number or a clock as large), and each of its parts has ended at its home.
// Several steps that a node took alone, one after the other, may share one number.
//
// Cost: O(log w) for each step, where w is the number of steps that wait.
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

  /// From now on, a core of this process takes each step, from the state `initial` on, and makes the text that is
  /// written about it. Requires that nodes send no texts (can_follow_steps), and that no step was reported yet.
  void follow(const State& initial) { follower_.emplace(core_, initial); }
  /// Returns false if a reported step was not possible in the state before it, or followed a run-time error. Such a
  /// step is not written, nor is any later one.
  [[nodiscard]] bool is_sound() const { return is_sound_; }
  /// Returns whether the step that was written last ended in a run-time error, also if its node did not report that.
  [[nodiscard]] bool has_met_fault() const { return follower_ && follower_->has_met_fault(); }
  /// Takes a report of one step (Control::Kind::Begun). Returns false if the message is malformed.
  bool take_begun(u32 node, const Control& control);
  /// Takes a report of several steps with their texts (Control::Kind::Took). Returns their number, or 0 if the message
  /// is malformed.
  u64 take_many(u32 node, const Control& control);
  /// Takes a report of the interactions of several steps (Control::Kind::Fired). Returns their number, or 0 if the
  /// message is malformed or this run needs texts of steps.
  u64 take_fired(u32 node, const Control& control);
  /// At `node`, one part of each of these steps has ended.
  void take_landed(u32 node, const std::vector<u64>& steps);
  /// The node will report no step with this number or a smaller one any more.
  void raise_bound(u32 node, u64 step) { bounds_[node] = std::max(bounds_[node], step); }
  [[nodiscard]] u64 bound(u32 node) const { return bounds_[node]; }
  /// The node is lost: from now on, steps wait neither for its reports nor for their parts at it.
  void lose(u32 node) { is_lost_[node] = true; }
  /// Writes the steps that need not wait any more.
  void write_ready();
  /// Writes the steps up to this number, whether their parts have ended or not.
  void write_until(u64 step);
  /// Number of steps that are written.
  [[nodiscard]] u64 written() const { return written_; }
  /// Number of reports whose steps are not written yet.
  [[nodiscard]] std::size_t waiting() const { return flights_.size(); }
  /// Bytes of the steps that are not written (record_bytes), now and at most so far.
  [[nodiscard]] u64 waiting_bytes() const { return waiting_bytes_; }
  [[nodiscard]] u64 most_waiting_bytes() const { return most_waiting_bytes_; }
  /// Bytes of the steps that are written (record_bytes).
  [[nodiscard]] u64 written_bytes() const { return written_bytes_; }
  /// Number (step_at) of the step that was written last; 0: none was.
  [[nodiscard]] u64 last_written() const { return last_written_; }
  /// Smallest number (step_at) of a step that is not written. Requires waiting() != 0.
  [[nodiscard]] u64 first_waiting() const { return flights_.begin()->first; }

 private:
  struct Step {
    InteractionId interaction;
    u32 rank = 0;  // of its candidate among those of the interaction, where a core takes the step (follow())
    // 1 + the offset in the step line, or in its text in the trace, at which the number of the step is inserted: only
    // here it is known. 0: nowhere.
    u64 out_number = 0, trace_number = 0;
    u64 out_size = 0, trace_size = 0;  // bytes of its step line, and of its text in the trace
  };
  // One report: a step, or several steps of one node that share a number.
  struct Flight {
    bool is_told = false;  // the report has come; before that, ends of parts may have
    std::vector<Step> steps;
    StepText text;                          // of all steps, one behind the other
    std::vector<std::pair<u32, int>> open;  // by node: the number of parts there that have not ended
    std::vector<InteractionId> fired;       // steps of which only the interactions were reported; then `steps` is empty
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
  std::vector<u64> bounds_;  // by node: it will report no step up to this number any more
  std::vector<bool> is_lost_;
  std::map<u64, Flight> flights_;  // those that are not written, by number
  std::optional<StepFollower> follower_;
  StepText text_;  // scratch
  bool is_sound_ = true;
  u64 written_ = 0, last_written_ = 0;
  u64 waiting_bytes_ = 0, most_waiting_bytes_ = 0, written_bytes_ = 0;
};

}  // namespace bip::rt
