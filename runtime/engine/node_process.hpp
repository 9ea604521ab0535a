// A node of a distributed run as a process: a Node (runtime/distributed), what chooses its steps, and its links to the
// other nodes and to the launcher (launcher.hpp), over a fabric.
//
// One thread: what came is taken, all steps that may begin are begun, actions are run, and what is to be said goes out
// in as few frames as that allows. While its own steps are short it goes on with them for 0.1 ms before it looks what
// came, unless it has something to say to another node. With nothing to do it sleeps.
#pragma once
#include <deque>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "runtime/core/core.hpp"
#include "runtime/distributed/fabric.hpp"
#include "runtime/distributed/greeting.hpp"
#include "runtime/distributed/node.hpp"
#include "runtime/distributed/fired_interactions.hpp"
#include "runtime/distributed/station.hpp"
#include "runtime/engine/node_time.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/engine/scheduler.hpp"
#include "runtime/engine/stall_watch.hpp"
#include "runtime/engine/unwritten_steps.hpp"

namespace bip::rt {

struct NodeSetup {
  const Image& image;
  CoreOptions core_options;
  const Distribution& distribution;
  u32 self = 0;
  u64 run = 0;  // its number, of the codec
  u64 seed = 0;
  const RunOptions& options;
  Output& output;                   // describes steps, and writes nothing
  std::vector<Arrival> early = {};  // frames of the run that came already
};

/// Steps in the order of the clocks of all nodes; of equal clocks the smaller node comes first.
inline constexpr unsigned kNodeBits = 6;
static_assert(kMostNodes == 1u << kNodeBits);
[[nodiscard]] constexpr u64 step_at(u64 clock, u32 node) { return clock << kNodeBits | node; }
[[nodiscard]] constexpr u32 node_of_step(u64 step) { return static_cast<u32>(step & (kMostNodes - 1)); }
/// The number that stands where the number of a step will be known later.
inline constexpr u64 kStepToCome = 18446744073709551610u;

class NodeProcess {
 public:
  NodeProcess(const NodeSetup& setup, Fabric& fabric);
  NodeProcess(const NodeProcess&) = delete;
  NodeProcess& operator=(const NodeProcess&) = delete;

  /// From the initial state until the launcher ends the run. False: it ended by itself; why() tells.
  bool run(const State& initial);
  [[nodiscard]] const std::string& why() const { return why_; }
  /// How the run ended, as the launcher said, and its steps; kNotTold.
  static constexpr u64 kNotTold = ~u64{0};
  [[nodiscard]] u64 told_end() const { return told_end_; }
  [[nodiscard]] u64 told_steps() const { return told_steps_; }

 private:
  // A message that must not be sent before the launcher has all that it depends on.
  struct Held {
    u64 frame;  // to the launcher
    Outgoing outgoing;
  };

  [[nodiscard]] bool begin_watch();
  void take_arrivals(i64 now);
  void take_greeting(const Arrival& arrival);
  [[nodiscard]] bool must_leave(i64 now);
  void take(const ReceivedMessage& heard);
  void take_control(const Control& control);
  void give_back();
  [[nodiscard]] bool has_worked(i64 now);
  [[nodiscard]] bool has_taken_turn();
  [[nodiscard]] bool has_tried();
  [[nodiscard]] bool has_begun();
  [[nodiscard]] bool may_begin();
  [[nodiscard]] bool takes_many() const;
  [[nodiscard]] bool has_taken_many();
  [[nodiscard]] u64 take_whole_steps(u64 step, u64 most);
  void note_fired(u64 step, u64 count);
  void say_fired();
  void say_whole(EnabledSet::Position at, u64 step);
  void say_begun(EnabledSet::Position at, u64 step, bool is_evaluated);
  [[nodiscard]] bool has_chosen(EnabledSet::Position& at);
  void describe(EnabledSet::Position at);
  void post();
  void send(i64 now);
  void release_held();
  void end_parkings(i64 now);
  void report(i64 now);
  void report_fault();
  void count(u64 round);
  void say_state();
  static void append_clocks(ByteWriter& writer, u32 atom, const SavedTime& time);
  [[nodiscard]] u64 cpu_spent() const;
  void say_last_state();
  void free_strings();
  [[nodiscard]] i64 next_due(bool has_work) const;
  [[nodiscard]] u64 sum_of_open(const std::vector<u64>& counts);
  void say(Control::Kind kind, std::vector<u64> numbers, std::vector<std::string> texts = {});

  u64 cpu_before_;  // microseconds of this process before the run
  const NodeSetup& setup_;
  Fabric& fabric_;
  u32 launcher_;
  bool writes_, holds_;
  Node node_;
  // Of steps: are they followed where they are written? Of those that are taken as a whole, is nothing said but their
  // interactions?
  bool is_followed_, says_interactions_;
  Codec codec_;
  Station station_;
  Scheduler scheduler_;
  NodeTime time_;
  std::optional<StallWatch> watch_;  // of runs on several hosts
  const State* initial_ = nullptr;

  bool is_remote_;   // the launcher may be on another host, and cannot watch this process
  i64 started_ = 0;  // ns of the wall clock
  std::string why_;
  u64 told_end_ = kNotTold, told_steps_ = 0;

  u64 credit_ = 0;   // steps that may begin
  u64 credits_ = 0;  // messages that gave some
  u64 steps_ = 0, border_steps_ = 0;
  bool wants_ = false, has_asked_ = false;
  UnwrittenSteps unwritten_;
  // Of steps that were taken and not said yet: their number, and their interactions (say_fired).
  u64 fired_step_ = 0;
  FiredPacker fired_;
  bool is_full_ = false;  // they are too many
  bool is_halted_ = false, is_paused_ = false, is_idle_ = false, is_finished_ = false;
  std::vector<u64> sent_, received_;  // by node: offers, begins, stops
  std::deque<Held> held_;
  // Since the last send: is there a message to anyone, or to another node?
  bool has_unsent_ = false, has_mail_ = false;
  u64 chunk_;              // steps to take at once
  InteractionId drawn_;    // while many steps were taken, and not taken: what begins next
  bool is_quick_ = false;  // do steps take so little time that the clock is not read after each?
  // Attempts that were parked here: until when, and their numbers (Node::Parking).
  using ParkedUntil = std::pair<i64, u64>;
  std::priority_queue<ParkedUntil, std::vector<ParkedUntil>, std::greater<>> parked_;
  i64 quiet_;           // ns of rest before it is reported
  i64 idle_since_ = 0;  // 0: reported, or at work
  u64 fault_step_ = ~u64{0};
  u32 fault_order_ = 0;
  // Scratch.
  std::vector<Arrival> arrivals_;
  std::vector<ReceivedMessage> heard_;
  std::vector<u32> atoms_;
  StepText text_;
};

}  // namespace bip::rt
