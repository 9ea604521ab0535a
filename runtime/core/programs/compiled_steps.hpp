// The short way: steps by the image's step functions (bip/steps.hpp), drawn uniformly from the list of the enabled or
// taken in its order; one after the other, or on several threads in epochs.
//
// A step costs a draw, two loads to find its run, one indirect call; less if the image has a function for many steps.
// Meanwhile ranks and rules are not kept up to date; rules are brought up to date at the end, which costs as much as
// the system is large if it has priorities. What flat connectors with guards offer the list of the enabled says;
// nothing else that is searched depends on an atom that a compiled step moves (compiler/steps), so an interaction
// without step function is fired by the core in between.
//
// An epoch costs two meetings of the threads and one pass over the list of the enabled, which is cut into the parts'
// lists before and joined after; so it is as long as the system is large.
#pragma once
#include <functional>
#include <vector>

#include "bip/prng.hpp"
#include "bip/steps.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/core/state/enabled_set.hpp"

namespace bip::rt {

struct CoreParts;
struct BatchPlan;
struct BatchPart;
class Profile;
class Team;

/// Interactions from `first` on with one compiled step.
struct CompiledRun {
  StepFn fn;
  const StepOperand* operands;
  InteractionId first;
  u64 inverse;
  /// Which one of the run the interaction is.
  [[nodiscard]] u32 index_of(InteractionId interaction) const {
    return static_cast<u32>((interaction.value - first.value) * inverse >> 32);
  }
};

/// A number for each interaction, by 64 interactions if those have the same, or the same as 64 others: small enough to
/// stay at hand.
struct RunRows {
  static constexpr u32 kInteractionsDiffer = 1u << 31;
  std::vector<u32> blocks;  // a number, or kInteractionsDiffer and where theirs are in `rows`
  std::vector<u32> rows;
  [[nodiscard]] u32 operator[](InteractionId interaction) const {
    return find(blocks.data(), rows.data(), interaction);
  }
  static u32 find(const u32* blocks, const u32* rows, InteractionId interaction) {
    const u32 row = blocks[interaction.value >> 6];
    if (row < kInteractionsDiffer || row == kNone) return row;
    return rows[row - kInteractionsDiffer + (interaction.value & 63)];
  }
};

class CompiledSteps {
 public:
  explicit CompiledSteps(CoreParts& core) : core_(core) {}
  /// Finds the runs. An interaction without one is fired by the core; if a rule might be evaluated then, all
  /// interactions that can fire have one (derive_steps). Again after take_new_code.
  void link();
  /// Has the image step functions for this system? To run them the list must be kept.
  [[nodiscard]] bool has_steps() const;
  /// Takes up to `limit` steps, drawn as EnabledSet::drawn does; returns how many. Asks is_stopped now and then. sound:
  /// false after a fault.
  u64 run(Prng& prng, u64 limit, bool (*is_stopped)(), bool& sound, Profile* profile = nullptr);
  /// The same in a partial state (PartialSteps), without rules, while it draws interactions that `takes` has, each with
  /// a step function: `drawn` is the first other one, which is not taken; none if there was none. No step faults.
  u64 run_among(const IndexVector<InteractionId, std::uint8_t>& takes, Prng& prng, u64 limit, InteractionId& drawn);
  /// Has the interaction a step function?
  [[nodiscard]] bool has_step(InteractionId interaction) const { return has_steps() && run_of_[interaction] != kNone; }
  /// The same, chosen by order. Needs the ordered list.
  u64 run(StepOrder& order, u64 limit, bool (*is_stopped)(), bool& sound, Profile* profile = nullptr);
  /// Has every interaction a step function?
  [[nodiscard]] bool can_batch() const;
  /// The same on the team's threads, in epochs (batch_plan.hpp), while there is enough to do for all; run must follow.
  /// record, unless empty, is given what was fired, in an order that is a run.
  u64 run_batch(const BatchPlan& plan, Team& team, Prng& prng, u64 limit, bool (*is_stopped)(),
                const std::function<void(const std::vector<InteractionId>&)>& record);
  /// Drops what only steps of the core need, if all steps are compiled; it is made anew when it is.
  void drop_programs();
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const {
    return (runs_.size() + inner_runs_.size()) * sizeof(CompiledRun) +
           (run_of_.blocks.size() + run_of_.rows.size() + first_entry_.size()) * sizeof(u32);
  }

 private:
  /// The core's arrays as compiled steps change them, with the list of the enabled set.
  [[nodiscard]] StepState state_of(const EnabledSet::List& list);
  template <class Choose, class Watch>
  u64 run_watched(Choose& given, u64 limit, bool (*is_stopped)(), bool& sound, Watch& watch);
  /// The same as `run` on arrays in inner order. Requires the image's inner steps.
  u64 run_inner(Prng& prng, u64 limit, bool (*is_stopped)());
  [[nodiscard]] bool takes_inner(u64 limit) const;
  /// Lets the core see what steps have done.
  [[nodiscard]] bool close_run(u32 count);
  void run_part(const BatchPlan& plan, BatchPart& part, bool records);
  void cut_list(const BatchPlan& plan, std::vector<BatchPart>& parts, u64 draws);
  void join_list(const std::vector<BatchPart>& parts);
  u64 run_shared(const BatchPlan& plan, Prng& prng, u64 draws, std::vector<InteractionId>& fired);

  CoreParts& core_;
  std::vector<CompiledRun> runs_;  // the image's runs of step functions
  std::vector<CompiledRun> inner_runs_;
  RunRows run_of_;                // by interaction: row of runs_, or kNone
  std::vector<u32> first_entry_;  // by shape: its rows of the image's entries, up to those of the next
  std::vector<u32> step_scratch_;
};

}  // namespace bip::rt
