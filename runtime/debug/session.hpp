// A debugging session: a run that a person steers forward and back. The console (`bipc step`) and the debug adapter
// (`bipc dap`) are faces of it.
//
// The session is no engine: runtime/core says what is enabled and what a step does, the policies and the timed
// scheduler of runtime/engine choose where the person does not. It records each move (a step, a delay, an event, a
// value that was set). Going back restores the nearest snapshot before the target and repeats the moves from there.
// Moves that lie ahead after going back are repeated by step() until another choice is made, which drops them (a
// branch).
//
// Snapshots are taken every `stride` moves. When they exceed their budget every second one is dropped and the stride
// doubles, so memory is bounded by the budget plus 8 bytes per move (16 with time), and going back costs one restore
// and fewer than `stride` steps, whatever the distance.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/debug/breakpoint.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/event_feed.hpp"
#include "runtime/engine/event_file.hpp"
#include "runtime/engine/timed_scheduler.hpp"

namespace bip::rt {

struct SessionOptions {
  std::uint64_t seed = 0;
  Policy policy = Policy::Uniform;
  bool asap = false;
  bool draws_resumes = true;  // where instants are planned; a run that is followed may not have
  MaximalProgress progress = MaximalProgress::On;
  /// C++ functions depend on nothing but their arguments: the session can go back in a model that calls C++.
  bool trusts_cpp = false;
  std::size_t snapshot_bytes = std::size_t{64} << 20;
};

/// How a movement ended. Done: all of it. Refused: nothing was done, problem() says why.
enum class Halt : std::uint8_t { Done, Breakpoint, Deadlock, Fault, Begin, Limit, Interrupted, Refused };

/// When last_move() is computed: with every move, or when it is asked for, which costs a step back and forth.
enum class Tracking : std::uint8_t { OnRequest, Every };

enum class MoveKind : std::uint8_t { Step, Delay, Event, Assign };

/// What an atom was before the last move.
struct AtomChange {
  u32 atom = 0;
  std::string places;               // empty: the same as now
  std::vector<u32> variables;       // that have other values now
  std::vector<std::string> values;  // the old ones
};
/// An atom's part in a step.
struct MovePart {
  u32 atom = 0, port = 0;
  SourceLine loc;  // of the transition
};
/// The last move, as a person wants to see it.
struct LastMove {
  MoveKind kind = MoveKind::Step;
  std::string text;       // a line without its newline: `#3  ROOT.k  p.put(v=1) c.get(v=0)`
  u32 connector = kNone;  // of a step; none for an internal port
  SourceLine loc;         // of the connector
  std::vector<MovePart> parts;
  std::vector<AtomChange> changes;
};

class TraceSink;

class DebugSession {
 public:
  /// A run that meets nothing to stop at ends after so many moves, which bounds the memory that they take.
  static constexpr std::uint64_t kMostMovesOfRun = 100'000'000;

  DebugSession(const Image& image, const SessionOptions& options);
  DebugSession(const DebugSession&) = delete;
  DebugSession& operator=(const DebugSession&) = delete;

  /// Events of a file (runtime/engine/event_file.hpp), before start(). False: `error` says what is wrong.
  [[nodiscard]] Result<bool> read_events(const std::string& path) { return feed_.read(path); }
  /// To the initial state. Fault if the model has none.
  Halt start();

  // ---- where the session is
  [[nodiscard]] Core& core() { return core_; }
  [[nodiscard]] const Core& core() const { return core_; }
  /// Moves from the initial state to here, and moves that are recorded, those ahead included.
  [[nodiscard]] std::uint64_t position() const { return position_; }
  [[nodiscard]] std::uint64_t length() const { return moves_.size(); }
  [[nodiscard]] bool is_at_fault() const { return is_faulty_; }
  [[nodiscard]] const std::string& problem() const { return problem_; }
  [[nodiscard]] std::string fault() const;
  /// The number of the candidate that the next recorded move takes; nothing if there is no such move.
  [[nodiscard]] std::optional<std::uint64_t> recorded_choice() const;
  /// What recorded move `row` (from 0) is, in a few words: `an event arrives at arm.coin`. Empty for a step: what it
  /// moves is seen in its state only.
  [[nodiscard]] std::string move_text(std::uint64_t row) const;
  /// The move that led here; nothing in the initial state. Goes back and forth by one step if need be.
  [[nodiscard]] const LastMove* last_move();
  void track(Tracking tracking) { tracking_ = tracking; }
  /// Empty: the session can go back. Else the reason why it cannot.
  [[nodiscard]] std::string back_refusal() const;

  // ---- forward
  /// Repeats the recorded move, or takes a step that the policy chooses.
  Halt step();
  /// Takes candidate k of this state. Drops the moves ahead unless the next one is the same.
  Halt choose(std::uint64_t k);
  /// Lets time pass to an instant. Refused where the model does not let it.
  Halt delay(i64 to);
  /// Delivers an event now.
  Halt post(const std::string& port, std::vector<EventValue> values);
  /// Sets a variable of an atom, which no run of the model does: traces of what follows are refused.
  Halt assign(u32 atom, u32 variable, Cell value);
  /// Up to `count` moves; stops at breakpoints, at the end, on Ctrl-C.
  Halt run(std::uint64_t count = kMostMovesOfRun);
  /// Drops the moves ahead.
  void branch();

  // ---- back
  Halt back(std::uint64_t count);
  /// To the last breakpoint before here, or to the initial state.
  Halt run_back();
  Halt go_to(std::uint64_t position);
  /// Notes where the session is, for undo(). At most kMaxMarks are kept.
  void mark();
  /// Forgets the last mark: the movement was refused.
  void drop_mark();
  /// To the last mark, with the moves that were recorded then. False: there is none.
  bool undo();

  // ---- runs recorded by others
  /// Passes time to `instant` and takes the candidate that `find` returns. Refused if there is none.
  Halt follow(i64 instant, const std::function<std::optional<EnabledSet::Position>(Core&)>& find);
  /// Repeats a record (`--record`), whose options the session was made with. Refused if the run differs from it.
  Halt follow_record(const std::string& path, const Record& record);
  /// Appends the steps from the initial state to here as a trace. False: problem() says why there is none.
  [[nodiscard]] bool append_trace(std::string& out, TraceFormat format);
  /// The same by a sink that writes this format.
  [[nodiscard]] bool append_trace(std::string& out, TraceFormat format, TraceSink& sink);

  // ---- breakpoints (breakpoint.hpp)
  [[nodiscard]] std::vector<Breakpoint>& breakpoints() { return breakpoints_; }
  /// Numbers of the breakpoints at which the last movement stopped.
  [[nodiscard]] const std::vector<u32>& reached() const { return reached_; }
  /// Called when a breakpoint with a message is reached, which does not stop.
  std::function<void(const Breakpoint&)> on_log;
  /// Asked now and then during run() and run_back(): true ends them. May be empty.
  std::function<bool()> is_stopped;

  static constexpr std::size_t kMaxMarks = 100;

 private:
  // What stands in the place of an interaction in a move that is no step.
  static constexpr InteractionId kDelay{kNone}, kEvent{kNone - 1}, kAssign{kNone - 2};
  static constexpr std::uint64_t kFirstStride = 64;
  struct Move {
    InteractionId interaction{0u};
    u32 rank = 0;  // kEvent: row of events_; kAssign: of assignments_
    friend bool operator==(const Move&, const Move&) = default;
  };
  struct Assignment {
    VariableId variable;
    Cell value{};
  };
  struct PostedEvent {
    Event event;
    bool is_posted = false;  // by the person
  };
  struct Snapshot {
    std::uint64_t position = 0;
    State state;
    std::vector<InteractionId> order;
    std::size_t bytes = 0;
  };
  struct Mark {
    std::uint64_t position = 0, cut = ~std::uint64_t{0};
    std::vector<Move> tail;  // dropped since, from `cut` on
    std::vector<i64> instants;
  };
  enum class Track : std::uint8_t { No, Yes };

  [[nodiscard]] bool has_ahead() const { return position_ < moves_.size(); }
  [[nodiscard]] Halt refuse(std::string why);
  Halt fail();
  Halt step_once();
  Halt step_at_tip();
  void record(Move move, i64 instant);
  void drop_ahead();
  void rewind_feed();
  void record_delivered(std::size_t first);
  bool apply(const Move& move, i64 instant, Track track);
  bool advance(i64 to);
  [[nodiscard]] bool assign_cell(const Assignment& assignment);
  [[nodiscard]] bool is_legal_delay(i64 to);
  Halt forward(Track track);
  void take_snapshot();
  void restore(const Snapshot& snapshot);
  [[nodiscard]] const Snapshot& nearest(std::uint64_t position) const;
  Halt return_to(std::uint64_t position);
  void begin_tracking(const Move& move);
  void end_tracking();
  void note_part(const Participant& part);
  void note_atom(u32 atom);
  [[nodiscard]] u32 atom_of(VariableId variable) const;
  void prepare_breakpoints();
  [[nodiscard]] bool check_breakpoints();
  void note_step(const Candidate& candidate);

  SessionOptions options_;
  Core core_;
  EventFeed feed_;
  TimedScheduler scheduler_;
  std::vector<Move> moves_;
  std::vector<i64> instants_;  // by move; empty in models without time
  std::vector<PostedEvent> events_;
  std::vector<Event> delivered_;  // by the feed, since the last look
  std::vector<Assignment> assignments_;
  std::uint64_t position_ = 0;
  bool is_faulty_ = false;
  bool is_fault_a_move_ = false;  // else it occurred while time passed after the last move
  std::string problem_;

  std::uint64_t stride_ = kFirstStride;
  std::vector<Snapshot> snapshots_;
  std::size_t snapshot_bytes_ = 0;
  std::vector<Mark> marks_;

  LastMove last_;
  Tracking tracking_ = Tracking::OnRequest;
  bool is_tracked_ = false;  // last_ is that of position_
  struct Before {
    u32 atom = 0;
    std::string places;
    std::vector<Cell> cells;
    std::vector<std::string> values;
  };
  std::vector<Before> before_;

  std::vector<Breakpoint> breakpoints_;
  std::vector<u32> reached_;
  bool watches_steps_ = false;   // some breakpoint is about who takes part
  std::vector<MovePart> parts_;  // of the step at hand, if so
  u32 connector_ = kNone;        // of the step at hand
  std::vector<Participant> participants_;
};

}  // namespace bip::rt
