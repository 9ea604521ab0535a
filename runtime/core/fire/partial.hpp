// Partial states: atoms may be at work while others go on (Basu, Bidinger, Bozga, Sifakis, "Distributed semantics and
// implementation for systems with interaction and priority", FORTE 2008). A step is *begun* (transfers run, tokens
// move, what takes part offers nothing any more) and each of its atoms is *finished* later, when its action has run
// somewhere else.
//
// Begun in this order, the steps are a run of the sequential semantics: each participant is in the state that the
// completed steps before left it in, and what else the step depends on must be at rest. That is said in *groups* of
// atoms:
// - of a connector that is no plain rendezvous (a larger interaction might come, or its guard or `up` may fault), all
// atoms
//   below it;
// - of priorities that chain, the atoms of all high sides and of all guards.
// A step may begin if no atom of the groups it depends on is at work. A group with guards, or of what may fault, is
// strict: an interaction that touches one of its atoms depends on it, so that every state of the group is looked at and
// its faults are the sequential ones.
//
// Several cores may share a system: each atom's data and actions are in one of them, its home, and it is offered in at
// most one at a time. In all others it is *away*, which is the same as being at work: what depends on it waits. What
// begins a step in one core, runs in another and is offered in a third is three calls here; who makes them is said in
// runtime/distributed.
#pragma once
#include <memory>
#include <vector>

#include "runtime/core/fire/fault.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/core/state/enabled_set.hpp"
#include "runtime/core/time/clocks.hpp"

namespace bip::rt {

/// An atom at work: its action runs next. Between begin and finish no other code reads the atom's data.
struct Work {
  u32 atom = kNone;
  const LinkedTransition* transition = nullptr;
  u32 internals = 0;  // internal transitions so far
  u64 step = 0;
  bool is_return = false;                   // of an action that runs beside the others (`@async`): its budget is over
  const LinkedTransition* fired = nullptr;  // before internal transitions: the one with a port
};
enum class Finished : std::uint8_t { Idle, More, Fault };  // More: the work now names an internal transition

/// What an atom at rest offers, apart from its data, and the step that brought it there.
struct AtomOffer {
  u32 place = kNone;             // of automata
  std::vector<u64> marks;        // of Petri types
  std::vector<u32> transitions;  // rows of Tables::transitions: of each enabled port
  u64 step = 0;
  u32 order = 0;  // in that step
  // Of atoms with time: of each of these transitions when; the instant at which the atom offers something else.
  std::vector<PortTime> times = {};
  i64 change = kForever;
};

struct PartialState {
  RowsByInteraction groups_of_interaction;  // those it depends on
  Csr groups_of_atom;
  std::vector<u32> busy_in_group;
  IndexVector<InteractionId, u32> own_group;  // of its connector, or kNone
  std::vector<u32> group_of_component;        // of priority rules
  RowsByInteraction atoms_of_interaction;     // all that may take part, sorted
  /// Two of its ports are one atom's; it is taken while nothing is at work.
  IndexVector<InteractionId, std::uint8_t> is_exclusive;

  std::vector<u64> last_step;  // by atom
  std::vector<u32> order;      // by atom: in that step
  std::vector<u32> rest;       // by atom that is away or at work: its last place. Empty: none is ever away
  u32 busy = 0;                // atoms at work
  u32 most_busy = 0;

  // The step that is being begun.
  u64 step = 0;  // or the one that was finished last
  u32 begun = 0;
  std::vector<Work>* works = nullptr;

  // The fault that a sequential run would have met first.
  bool noted = false;
  Fault fault;
  u64 fault_step = 0;
  u32 fault_order = 0;
};

/// All port instances that may take part.
void ports_of_interaction(const Tables& tables, const InteractionInfo& info, std::vector<u32>& out);
/// All atoms that may take part, sorted; one twice if two of its ports may.
void atoms_of_interaction(const Tables& tables, const InteractionInfo& info, std::vector<u32>& out);

struct PriorityTables;
[[nodiscard]] PartialState link_partial(const Tables& tables, const PriorityTables& rules);

struct CoreParts;

/// Steps begun and finished apart. One caller at a time; only `run` may go on elsewhere.
class PartialSteps {
 public:
  explicit PartialSteps(CoreParts& core) : core_(core) {}
  /// From now on only these take steps. Of an initialized image; with time, only in cores that share the system.
  void allow();
  [[nodiscard]] bool is_on() const { return state_ != nullptr; }
  /// Null unless it is on.
  [[nodiscard]] const PartialState* state() const { return state_.get(); }
  /// May a candidate of the interaction begin, although atoms are at work?
  [[nodiscard]] bool is_decided(InteractionId interaction) const;
  /// Begins the step. Appends what must run then, also if it returns false: a fault.
  bool begin(EnabledSet::Position at, u64 step, std::vector<Work>& works);
  /// Takes the step as a whole: all that take part, of atoms that are at rest and have their data and actions here, are
  /// at rest and offered here again. Requires an interaction that depends on no group, without time. False: a fault.
  bool take_whole(EnabledSet::Position at, u64 step);
  /// Runs the work's action; returns its status.
  [[nodiscard]] std::int32_t run(const Work& work);
  /// Lets the action take effect. More: the work must run again.
  Finished finish(Work& work, std::int32_t status);
  /// Ends it, nothing being at work. False: a fault was met; the core's fault is the one of the earliest step.
  bool end();

  // ---- several cores
  /// From now on atoms may be away. Of a core that allowed partial steps.
  void share();
  /// The atom, at rest and offered here, is away from now on. Settle follows.
  void send_away(u32 atom);
  /// Takes the candidates of interactions at which settle() did not look, as atoms that they depend on are away, out of
  /// the enabled set until it does. Of a state that was restored as a whole: these atoms may never be offered here, and
  /// their candidates of that state would count for ever.
  void drop_held();
  /// An atom that is at home here and away begins the transition (row of Tables::transitions) that another core's step
  /// `step` gave it as its `order`-th. False: a fault.
  bool take_up(u32 atom, u32 transition, u64 step, u32 order, Work& work);
  /// As finish, but for what follows: Idle means that the atom is at rest and not yet offered anywhere.
  Finished come_to_rest(Work& work, std::int32_t status);
  /// Of an atom at home here whose ports may change at this instant, which has the number `step` among the steps: what
  /// follows is of it.
  void begin_change(u32 atom, u64 step);
  /// Of an atom whose action beside the others began before the first step, as number `order` of those.
  void note_begun(u32 atom, u32 order) { state_->order[atom] = order; }
  /// The budget of the atom's action is over: the action runs next. Of an atom that is away.
  [[nodiscard]] Work return_action(u32 atom);
  /// Finds anew what the atom, at home and offered here, offers. False: a fault. Settle follows.
  bool change_here(u32 atom);
  /// The enabled ports (of its type) of an atom that is at rest here. False: a fault.
  bool find_enabled_ports(u32 atom, std::vector<u32>& ports);
  /// What the atom, which came to rest here, offers to another core; here it is away. False: a fault.
  bool offer_away(u32 atom, AtomOffer& offer);
  /// The atom, which came to rest here, is offered here. False: a fault.
  bool offer_here(u32 atom);
  /// The atom came to rest elsewhere and is offered here; its data have been written. False: a fault.
  bool receive(u32 atom, const AtomOffer& offer);
  /// Where the atom is at rest, or was before it went to work; of automata.
  [[nodiscard]] u32 place_at_rest(u32 atom) const;

  // ---- for the other parts of the core
  /// Does a step begin? Then its ports' actions are not run, but noted.
  [[nodiscard]] bool is_beginning() const { return is_beginning_; }
  bool begin_port(u32 instance);
  /// As CoreParts::settle; what depends on atoms at work waits. A fault does not end it: an earlier step's may follow.
  bool settle();

 private:
  [[nodiscard]] const Async* async_of(const Work& work) const;
  void withdraw(u32 atom);
  void occupy(u32 atom);
  void release(u32 atom);
  void note_fault(u64 step, u32 order);
  [[nodiscard]] u64 last_step_of(InteractionId interaction) const;

  CoreParts& core_;
  std::unique_ptr<PartialState> state_;  // null: steps are taken at once
  bool is_beginning_ = false;
};

}  // namespace bip::rt
