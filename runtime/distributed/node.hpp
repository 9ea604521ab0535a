// A node of a distributed run, as a state machine: messages come in, messages go out, and in between it says which
// steps it may begin and which actions wait to be run. No input or output, no clock, no thread; the caller decides
// when.
//
// It has a core of the whole image. Atoms at home here have their data in it. What it coordinates it begins as the core
// allows: atoms that are elsewhere, or offered elsewhere, are away, so all that depends on them waits
// (core/fire/partial.hpp). A step that it begins runs here for the atoms at home here, and is a BEGIN for others;
// an atom that comes to rest is offered to the one node that coordinates what it can do next. A step of atoms that are
// at home and always offered here can also be taken as a whole, as a sequential run takes it (take_whole).
//
// Split sets (node_locks.cpp): an atom that several coordinators can take stays offered in the core of its home. To
// offer it in another core is to lock it: an attempt to begin an interaction takes what its coordinator has, goes from
// home to home in their order with the offers of all that it holds, and waits at an atom that is at work or locked. At
// one that cannot take part it is parked: it goes on when the atom can, and is refused when the caller says so
// (end_parking). At the last home all that the interaction needs is offered in one core, which decides about it as
// about any other, and begins it or gives everything back. What was refused is tried again when an atom that it was
// refused for has changed.
//
// Models with time: all nodes pass from one instant to the next, which the caller computes when all of them rest and
// no message is on its way (engine/node_time.hpp). An atom's home has its clocks. An offer says until when it holds;
// after that its coordinator counts the atom as at work, and its home offers it again. An action that runs beside the
// others (`@async`) is such a change: the atom offers nothing until its budget is over, and its action runs then.
#pragma once
#include <deque>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "runtime/core/core.hpp"
#include "runtime/distributed/distribution.hpp"
#include "runtime/distributed/message.hpp"

namespace bip::rt {

struct NodeCounts {
  u64 offers = 0, begins = 0;              // messages sent
  u64 locks = 0, releases = 0, wakes = 0;  // of split sets
  u64 stale = 0;                           // messages that came again
  u64 refused = 0;                         // what no sound peer says in the state of this node
};

/// What happens to an atom, as models/protocol/offer_begin.bip tells it, and to an attempt to lock atoms for an
/// interaction, as models/protocol/lock_chain.bip does.
struct NodeEvent {
  enum class Kind : std::uint8_t {
    Begun,     // its coordinator begins a step with it
    Taken,     // its home takes the step
    Rested,    // it is at rest again, at `place`
    Offered,   // its home offers it
    Received,  // its coordinator has the offer
    Locked,    // an attempt takes it along
    Arrived,   // a LOCK has come to another home; of no atom
    Parked,    // it cannot take part, and the attempt waits
    GivenUp,   // the attempt was parked at it, and ends
    Refused,   // it cannot take part, and the attempt ends
    Released,  // it is offered again as it was before the attempt
    Woken,     // it has changed, and its home sends WAKE
    Heard      // the coordinator has the WAKE; of no atom
  };
  Kind kind = Kind::Begun;
  u32 atom = kNone;
  InteractionId interaction;  // of a step: the step's; of an attempt: what it is for
  u32 place = kNone;          // of automata
};
using NodeObserver = std::function<void(NodeEvent)>;

/// The time of a state, as nodes say it.
struct SavedTime {
  /// An atom whose action runs beside the others: which step began it, and AsyncActions::save_work.
  struct Beside {
    u64 step = 0;
    u32 order = 0;
    std::vector<i64> words;
  };
  i64 now = 0;
  std::vector<std::vector<i64>> clocks;  // by atom: Clocks::save_atom; empty: it is not known
  std::vector<Beside> beside;
};

class Node {
 public:
  /// All arguments must outlive the node.
  Node(const Image& image, const CoreOptions& options, const Distribution& distribution, u32 self)
      : distribution_(distribution), self_(self), core_(image, options) {
    link_locks();
  }

  [[nodiscard]] Core& core() { return core_; }
  [[nodiscard]] const Core& core() const { return core_; }
  /// To the initial state, which all nodes know. False: a fault.
  bool start(const State& state);

  /// Calls `observer` with each event from now on; for tests.
  void observe(NodeObserver observer) { observer_ = std::move(observer); }
  /// Takes a message of another node. Requires what Codec::read checks. What does not fit the state of this node is
  /// refused and counted.
  void take(const Message& message);
  /// Begins a candidate that is_decided, as step `step` of the whole run: numbers grow along whatever depends on
  /// something. Appends the atoms that take part. Returns whether the step has one part more, which lands here: when
  /// what depends on its atoms has been evaluated. A fault of that is a fault of this step.
  bool begin(EnabledSet::Position at, u64 step, std::vector<u32>& atoms);
  /// Can steps of the interaction be taken by take_whole: all of its atoms are at home here and always offered here,
  /// and nothing else depends on them? Of a node that is observed none: its events are those of steps in parts.
  [[nodiscard]] bool is_whole(InteractionId interaction) const {
    return whole_steps_[interaction] != WholeSteps::None && !observer_;
  }
  /// As begin, and runs all actions of the step, which is_whole, at once: when it returns the step has ended. False: by
  /// a fault. It is not added to `landed`: note_landed does that.
  bool take_whole(EnabledSet::Position at, u64 step);
  /// Are there steps that take_whole could take, and that have compiled code? Changes for the worse only: when the node
  /// is observed.
  [[nodiscard]] bool has_compiled() const { return has_compiled_ && !observer_; }
  /// Takes such steps, drawn uniformly, by their compiled code, kMostCompiled at most. Ends when it draws another
  /// interaction, `drawn`, which is not taken; then no atom may move before its candidate is begun or drawn again. None
  /// was drawn: nothing is enabled, or the limit is reached. Returns how many. They do not fault, and are not added to
  /// `landed`.
  u64 take_compiled(Prng& prng, u64 limit, InteractionId& drawn);
  static constexpr u64 kMostCompiled = 1024;
  /// Can any step be taken by take_whole?
  [[nodiscard]] bool has_whole() const { return has_whole_ && !observer_; }
  /// Of such a step: appends the atoms that take part, and the step to `landed`, once for each.
  void note_landed(InteractionId interaction, u64 step, std::vector<u32>& atoms);
  /// The interaction of a split set that must begin next, as all that it needs is locked here: the caller chooses one
  /// of its candidates. kNone: there is none.
  [[nodiscard]] InteractionId locked_interaction() const {
    return ready_.empty() ? InteractionId() : ready_.front().interaction;
  }
  /// Interactions of split sets that may be worth an attempt.
  [[nodiscard]] std::size_t try_count() const { return tries_.size(); }
  /// Attempts one of them, if what it needs here is offered here.
  void try_lock(std::size_t k);
  /// An attempt that waits at an atom at home here which cannot take part in it. Its number is never used again.
  struct Parking {
    u64 number = 0;
    InteractionId interaction{0u};
  };
  /// Those that began to wait; the reader empties it, and ends each after some time with end_parking. What a refusal
  /// costs is a good time: nothing but time and messages depends on it.
  [[nodiscard]] std::vector<Parking>& new_parkings() { return new_parkings_; }
  /// Does an attempt wait so? Then the node does not rest: that attempt will go on or be refused.
  [[nodiscard]] bool has_parked() const { return !parked_at_.empty(); }
  /// Refuses the attempt, unless it has gone on.
  void end_parking(u64 number);
  /// Lets time pass to an instant that the whole system agreed on, or learns that it is there already.
  void pass_to(Moment moment);
  /// Actions that wait to be run.
  [[nodiscard]] std::size_t work_count() const { return works_.size(); }
  /// Runs one of them and lets it take effect.
  void run(std::size_t k);

  /// Messages to send, in this order; the sender empties it.
  [[nodiscard]] std::vector<Outgoing>& outbox() { return outbox_; }
  /// Another node is lost: what its atoms did is not evaluated any more.
  void forget_lost(u32 node);
  /// Steps of which a part has ended here: an atom came to rest, or what depends on all of them was evaluated. The
  /// reader empties it.
  [[nodiscard]] std::vector<u64>& landed() { return landed_; }
  /// A fault was met, here or elsewhere: it begins nothing more.
  [[nodiscard]] bool is_stopped() const { return is_stopped_; }
  [[nodiscard]] const NodeCounts& counts() const { return counts_; }
  /// Writes places and data of the atoms at home here into a state of the image, and their clocks apart.
  void save(State& state, SavedTime& time) const;
  /// Is an atom at home here locked by an attempt?
  [[nodiscard]] bool is_locked(u32 atom) const { return where_[atom] == Where::Locked; }
  /// NextMove::history of an atom at home here.
  [[nodiscard]] u32 history(u32 atom) const { return history_[atom]; }
  /// Calls `take` with each row of variables that is not in the core: of messages to send and of attempts.
  template <class Take>
  void visit_kept_cells(Take take) const {
    for (const Outgoing& outgoing : outbox_) visit_cells(outgoing.message, take);
    for (const std::deque<Lock>& locks : waiting_) {
      for (const Lock& lock : locks) visit_cells(lock, take);
    }
    for (const std::deque<ParkedLock>& parked : parked_) {
      for (const ParkedLock& at : parked) visit_cells(at.lock, take);
    }
    for (const Lock& lock : ready_) visit_cells(lock, take);
  }

 private:
  /// WithHistory: of atoms whose next moves depend on the connector that they took part in last.
  enum class WholeSteps : std::uint8_t { None, Plain, WithHistory };
  void start_actions();
  void take(const Offer& offer);
  void take(const Begin& begin);
  void take(const Stop&) { is_stopped_ = true; }
  void take(const Control&) {}
  void take(const Lock& lock);
  void take(const Release& release);
  void take(const Wake& wake);
  void land_evaluated();
  void link_whole();
  void link_compiled();
  /// Those of an interaction in which always the same ones take part; none of others. They may be part of `info`.
  [[nodiscard]] Span<u32> ports_of_whole(const InteractionInfo& info) const;
  Span<u32> ports_of_whole(InteractionInfo&& info) const = delete;
  void note_histories(InteractionId interaction);
  void note_last_histories(u64 steps);
  void come_to_rest(u32 atom);
  void change(u32 atom);
  void receive(const Offer& offer);
  [[nodiscard]] bool may_take_up(const Part& part, InteractionId interaction) const;

  // ---- locks: node_locks.cpp
  enum class Where : std::uint8_t { Away, Here, Working, Locked };
  enum class Blocked : std::uint8_t { No, ByAtom, ByAll };
  struct Watcher {
    InteractionId interaction{0u};
    u64 n = 0;
  };
  struct ParkedLock {
    u64 number = 0;
    Lock lock;
  };
  void link_locks();
  void start_locks();
  [[nodiscard]] bool has_split() const { return !distribution_.locks.items.empty(); }
  [[nodiscard]] bool fits(InteractionId interaction, u32 atom);
  [[nodiscard]] bool is_offered_for(InteractionId interaction, u32 atom, u32 port) const;
  [[nodiscard]] bool may_try(InteractionId interaction);
  void list_try(InteractionId interaction);
  void list_tries(u32 atom);
  void unblock(InteractionId interaction);
  void note_change(u32 atom);
  void note_success(InteractionId interaction);
  void lend(u32 atom, Lock& lock);
  void take_back(u32 atom, const AtomOffer& offer);
  void take_back(const Release& release);
  [[nodiscard]] bool may_come_back(u32 atom, InteractionId interaction) const;
  [[nodiscard]] bool is_waiting(InteractionId interaction) const;
  [[nodiscard]] bool may_hold(const Lock& lock) const;
  void drop(const Lock& lock);
  void park(u32 atom, Lock lock);
  [[nodiscard]] Lock take_parked(u32 atom, std::size_t k);
  void serve_parked(u32 atom);
  void go_on(Lock lock, u32 served);
  void hold_all(Lock lock);
  void refuse(const Lock& lock, bool is_watched);
  void end_attempt();
  void release(const Lock& lock, const std::vector<u32>& atoms, bool is_refused, bool is_watched);
  void watch(u32 atom, InteractionId interaction, u64 n);
  void wake_watchers(u32 atom);
  void serve();
  void note_history(u32 atom, const LinkedTransition& transition, InteractionId interaction);
  bool find_coordinator(u32 atom, u32& coordinator, u32& set);
  void stop();
  void tell(NodeEvent::Kind kind, u32 atom, InteractionId interaction = {}, u32 place = kNone) const {
    if (observer_) observer_({kind, atom, interaction, place});
  }

  const Distribution& distribution_;
  u32 self_;
  Core core_;
  std::vector<u64> participations_;  // by atom: at home, how often it took part; elsewhere, as its last offer said
  std::vector<u32> history_;         // by atom at home: the connector that tells its next moves apart (NextMove)
  std::vector<Work> works_, begun_;
  std::vector<Outgoing> outbox_;
  std::vector<u64> landed_;
  // Steps begun here after which a guard, an `up` or a rule may fault, until these have been evaluated.
  struct Unevaluated {
    u64 step = 0;
    InteractionId interaction{0u};
  };
  std::vector<Unevaluated> unevaluated_;
  std::vector<u32> enabled_, ports_, changed_;  // scratch
  IndexVector<InteractionId, WholeSteps> whole_steps_;
  bool has_whole_ = false;
  // Steps that are taken by compiled code: are there any, are all that can begin here, of how many atoms do they tell
  // moves apart?
  bool has_compiled_ = false, is_all_compiled_ = false;
  u32 compiled_histories_ = 0;
  IndexVector<InteractionId, std::uint8_t> is_compiled_;
  std::vector<u64> history_noted_;  // by atom: by which call of note_histories
  u64 noting_ = 0;
  NodeCounts counts_;
  Moment moment_;
  NodeObserver observer_;
  // Locks. By atom: where it is, as far as this node knows; of those at home here: attempts that wait for it, attempts
  // that are parked at it, and interactions that were refused for it; interactions coordinated here that need locks
  // elsewhere and the atom.
  std::vector<Where> where_;
  std::vector<std::uint8_t> is_in_core_;  // offered in this core
  std::vector<u32> offered_for_;          // of atoms from elsewhere: Offer::set
  std::vector<std::deque<Lock>> waiting_;
  std::vector<std::deque<ParkedLock>> parked_;
  std::vector<std::vector<Watcher>> watchers_;
  InteractionsBy tries_of_;
  // By interaction coordinated here: why it is not tried; was an atom that it needs heard of since it was tried last?
  IndexVector<InteractionId, Blocked> blocked_;
  IndexVector<InteractionId, std::uint8_t> is_awake_, is_listed_;
  std::vector<InteractionId> tries_;
  std::vector<AtomOffer> lent_;  // by atom that an attempt took along from here
  // By atom from elsewhere: the interaction whose attempt has it, or none; by atom at home here that is locked: the
  // interaction.
  std::vector<InteractionId> taken_by_;
  std::map<InteractionId, std::vector<u32>> attempted_;  // by interaction that is being attempted: those atoms
  std::deque<Lock> ready_;                               // attempts of which all is locked here
  std::deque<u32> served_;                               // atoms at home here that may be given to who waits
  std::map<u64, u32> parked_at_;                         // by number of an attempt that is parked here: the atom
  std::vector<Parking> new_parkings_;
  u64 parkings_ = 0;
  bool is_stopped_ = false;
};

/// Into the order in which they began.
void sort_by_begin(std::vector<SavedTime::Beside>& beside);
/// Puts the clocks of all nodes into their state, which has those of the initial state, as the core is.
void add_time(const Core& core, SavedTime time, State& state);

}  // namespace bip::rt
