// The core: the only meaning of *enabled* and *fire* (compiler/docs/semantics.md). Engines, explorer, debugger and
// replays all drive it: initialize, look at the candidates, fire one, look again. Faults (R codes) stop it: initialize
// and fire return false, fault() tells why.
//
// Needs an image with code in it, which must outlive it. After a step only the atoms that moved look at their
// transitions, only connectors that watch what changed are looked at again: its cost is proportional to what it
// touched. No allocation in steady state unless a guarded connector is searched.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "bip/prng.hpp"
#include "runtime/core/search/bits.hpp"
#include "runtime/core/core_rows.hpp"
#include "runtime/core/state/ffi_data.hpp"
#include "runtime/core/fire/fault.hpp"
#include "runtime/core/fire/partial.hpp"
#include "runtime/core/link/priorities.hpp"
#include "runtime/core/state/enabled_set.hpp"
#include "runtime/core/state/state.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/core/time/time_state.hpp"

namespace bip::rt {

struct BatchPlan;
struct BatchPart;
class Team;
/// Has an atom to do with time?
[[nodiscard]] bool has_time(const Image& image);

class Core {
 public:
  explicit Core(const Image& image, CoreOptions options = {});
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  /// The initial state. False: a fault.
  [[nodiscard]] bool initialize();

  [[nodiscard]] std::uint64_t candidate_count() const { return enabled_.total(); }
  /// The k-th candidate in canonical order, k < candidate_count(). O(log interactions).
  [[nodiscard]] Candidate candidate(std::uint64_t k) const { return candidate(enabled_.select(k)); }
  /// The number of the first candidate in an interaction greater than `interaction`, cyclically. O(log interactions).
  [[nodiscard]] std::uint64_t next_after(u32 interaction) const;

  // ---- the list of the interactions that have candidates, whose order is the history's: what the policy `uniform`
  // draws from
  /// From now on, starting in canonical order. `initialize` and `restore` start it anew.
  void keep_list();
  /// In the list's order; empty without one.
  [[nodiscard]] std::vector<u32> list_order() const;
  void set_list_order(const std::vector<u32>& order);
  /// The k-th candidate in the list's order while every interaction in it has one, else in canonical order; k <
  /// candidate_count(). Needs the list. O(1) while every interaction has one.
  [[nodiscard]] EnabledSet::Position drawn(std::uint64_t k) const {
    if (enabled_.listed_count() == enabled_.total()) return {enabled_.listed(k), 0};
    return enabled_.select(k);
  }
  /// Where the k-th candidate in canonical order is. O(log interactions).
  [[nodiscard]] EnabledSet::Position position(std::uint64_t k) const { return enabled_.select(k); }
  /// The number of a candidate in canonical order. O(log interactions).
  [[nodiscard]] std::uint64_t number(EnabledSet::Position at) const { return enabled_.rank(at.interaction) + at.rank; }
  [[nodiscard]] Candidate candidate(EnabledSet::Position at) const;
  /// Is there such a candidate?
  [[nodiscard]] bool has(EnabledSet::Position at) const {
    return at.interaction < tables_.interactions.size() && at.rank < enabled_.weight(at.interaction);
  }
  /// Takes the step. False: a fault; the state is then between two stable ones.
  bool fire(const Candidate& candidate);
  bool fire(std::uint64_t k) { return take(enabled_.select(k)); }
  /// fire(candidate(at)) by the shortest way. The engine's loop.
  bool take(EnabledSet::Position at) {
    if (rows_.empty()) build_programs();
    const u32* program = rows_.data() + std::size_t{at.interaction} * row_words_;
    return *program != kNone ? run_program(program, at.interaction) : fire_parts(candidate(at));
  }
  void drop_programs();  // if all steps are compiled; `take` and `fire` make them anew
  /// Has the image step functions for this system, and is the list kept?
  [[nodiscard]] bool has_steps() const { return !run_of_.blocks.empty() && keeps_list_; }
  /// The image has other code now, which means the same, or compiled steps that it had not. `before`: its rows as they
  /// were.
  void take_new_code(const std::vector<Code>& before);
  /// Up to `limit` steps, drawn as `drawn` does; returns how many. Asks is_stopped now and then. sound: false after a
  /// fault.
  u64 run_steps(Prng& prng, u64 limit, bool (*is_stopped)(), bool& sound, Profile* profile = nullptr);
  /// Has every interaction a step function?
  [[nodiscard]] bool can_batch() const;
  /// The same on the team's threads, in epochs (batch.hpp), while there is enough to do for all; run_steps must follow.
  /// record, unless empty, is given what was fired, in an order that is a run.
  u64 run_batch(const BatchPlan& plan, Team& team, Prng& prng, u64 limit, bool (*is_stopped)(),
                const std::function<void(const std::vector<u32>&)>& record);
  [[nodiscard]] const PriorityTables& priorities() const { return rules_; }
  static constexpr u32 kHistory = StepHistory::kSize;
  /// The interactions fired last, at most kHistory of them, in their order.
  [[nodiscard]] std::vector<u32> recent_interactions(u64 count) const;

  /// The atom ports that take part, in the order in which they fire.
  void participants(const Candidate& candidate, std::vector<Participant>& out);
  /// The ports of the connector itself; exported ports of connectors below as such, with this candidate's values: runs
  /// `up`.
  void direct_participants(const Candidate& candidate, std::vector<Participant>& out);

  [[nodiscard]] State snapshot() const;
  /// To a state of the same image. Cost: a comparison of the states, plus what differs.
  bool restore(const State& state);

  [[nodiscard]] const Fault& fault() const { return fault_; }
  [[nodiscard]] const Image& image() const { return *tables_.image; }
  [[nodiscard]] const Tables& tables() const { return tables_; }

  // ---- time (timed.cpp); 0 and nothing in images without
  [[nodiscard]] bool is_timed() const { return time_ != nullptr; }
  [[nodiscard]] i64 now() const { return time_ == nullptr ? 0 : time_->now; }
  /// Lets time pass to an instant, no later than next_change() unless last_instant() comes first. False: a fault.
  bool advance(i64 to);
  /// The next instant at which a port may change by itself; kForever: none will.
  [[nodiscard]] i64 next_change() const { return time_->changes.first_key(); }
  /// The last instant that the invariants allow.
  [[nodiscard]] i64 last_instant() const { return time_->ends.first_key(); }
  [[nodiscard]] i64 time_unit() const;
  /// The last instant to which time may pass in this state, candidates' urgency and invariants considered; of each
  /// candidate the last instant of its interval.
  i64 wait_limit(std::vector<i64>& ends);
  /// Of a candidate of this instant.
  CandidateTime time_of(const Candidate& candidate);
  /// take(at), with what time adds to it.
  bool take_timed(EnabledSet::Position at);
  /// The fault of a state in which neither a step nor time can go on. Always false.
  bool fail_time_lock();
  /// Real time: the step was planned for now, could start until `last`, and starts at `actual`. Always false.
  bool fail_late(const Candidate& candidate, i64 last, i64 actual);
  // ---- conditions on clocks apart from the instant, for who explores all instants at once (measured.cpp). False: a
  // fault.
  [[nodiscard]] bool measure(u32 atom, const TimeGuard& when, MeasuredGuard& out);
  /// The labelled transitions that the atom's marking and data enable, whether it is busy or not and whether events
  /// wait or not.
  [[nodiscard]] bool timed_transitions(u32 atom, std::vector<TimedTransition>& out);
  /// Of the invariants in scope, those that bound clocks.
  [[nodiscard]] bool timed_invariants(u32 atom, std::vector<MeasuredGuard>& out);
  /// What the atom waits for after a transition (a row of its type's; kNone: after `initial`).
  [[nodiscard]] bool measured_resume(u32 atom, u32 row, MeasuredGuard& out);
  /// Rows of all clocks that the last timed step has set; first_clock: of an atom.
  [[nodiscard]] const std::vector<u32>& set_clocks() const { return time_->set_clocks; }
  [[nodiscard]] u32 first_clock(u32 atom) const { return time_->clock_base[atom]; }
  [[nodiscard]] const ClockState& clock_state(u32 row) const { return time_->clocks[row]; }
  /// A clock's value in ticks.
  [[nodiscard]] Int128 clock_value(u32 atom, u32 clock) const;

  // ---- events from outside (events.cpp)
  /// The atoms' ports for them, in canonical order; a row is how others name one. Empty in images without.
  [[nodiscard]] const std::vector<EventPortRow>& event_ports() const;
  /// An event comes at this instant, with one value for each variable of the port's type. False: a fault.
  bool deliver(u32 row, const Cell* values);
  /// What has gone wrong outside, at this instant. Always false.
  bool fail_outside(FaultCode code, const std::string& what);
  /// How many came to the port and were not taken.
  [[nodiscard]] u32 waiting_events(u32 row) const { return time_->queues[row].count; }
  [[nodiscard]] bool is_event_port(u32 atom, u32 port) const {
    return time_ != nullptr && event_row(tables_.instance(atom, port)) != kNone;
  }
  /// A variable of a port as a step shows it: of a port for events what the event brings.
  [[nodiscard]] const Cell& shown(u32 atom, u32 port, u32 variable) const;

  // ---- partial states (partial.hpp): steps begun and finished apart. One caller at a time; only `run` may go on
  // elsewhere
  /// From now on only these take steps. Of an initialized image without time.
  void allow_partial();
  /// May a candidate of the interaction begin, although atoms are at work?
  [[nodiscard]] bool is_decided(u32 interaction) const;
  /// Appends what must run then, also if it returns false: a fault.
  bool begin(EnabledSet::Position at, u64 step, std::vector<Work>& works);
  [[nodiscard]] std::int32_t run(const Work& work);
  Finished finish(Work& work, std::int32_t status);
  [[nodiscard]] const PartialState* partial() const { return partial_.get(); }
  /// Ends it, nothing being at work. False: a fault was met; fault() is the one of the earliest step.
  bool end_partial();
  // ---- actions that run beside the others (async.cpp)
  [[nodiscard]] bool has_async() const { return time_ != nullptr && !time_->at_work.empty(); }
  /// Before the first step: from now on actions end when return_action says so, not with their budget. pool: null: they
  /// run then.
  void await_returns(ActionPool* pool);
  /// The atoms whose actions have not taken effect, in the order in which they began; what of one of them.
  [[nodiscard]] const std::vector<u32>& working() const { return time_->working; }
  [[nodiscard]] bool is_at_work(u32 atom) const { return has_async() && time_->at_work[atom].transition != kNone; }
  [[nodiscard]] const AtWork& work_of(u32 atom) const { return time_->at_work[atom]; }
  void mark_overrun(u32 atom) { time_->at_work[atom].is_overrun = true; }
  /// The action takes effect at this instant; it is waited for. False: a fault.
  bool return_action(u32 atom);

  // ---- looking at the state
  [[nodiscard]] const Cell& cell(u32 row) const { return all_[row]; }
  [[nodiscard]] bool is_marked(u32 atom, u32 place) const;
  /// The transition (row of the type's) that the port would fire, or kNone if the port is disabled.
  [[nodiscard]] u32 enabled_transition(u32 atom, u32 port) const;
  /// By atom the interaction of the last step in which it may have taken part, as far as the core remembers; kNone: not
  /// known. No part of the state.
  [[nodiscard]] std::vector<u32> last_interactions() const;
  /// Is a node of the availability network available? (semantics.md)
  [[nodiscard]] bool is_available(u32 node) const { return values_[node] >= 0; }
  /// Candidates of the connector before priorities; 0 also if it exports a port.
  [[nodiscard]] u32 listed_count(u32 connector) const;
  [[nodiscard]] MemoryUse memory() const;  // by count of rows
  /// Of connectors whose candidates are searched.
  [[nodiscard]] const SearchWork& search_work() const { return search_work_; }

 private:
  FlatGuard flat_guard(const InteractionInfo& info);
  [[nodiscard]] bool looks_at_binds() const {
    return tables_.any_searched || rules_.count != 0 || time_ != nullptr || image().choices.size != 0;
  }
  void forget();
  bool settle_anew();
  [[nodiscard]] u32 listing_of(u32 interaction) const { return listing_of_.empty() ? kNone : listing_of_[interaction]; }
  void remember(u32 interaction) { history_[std::exchange(history_at_, (history_at_ + 1) % kHistory)] = interaction; }
  [[nodiscard]] u32 enabled_row(u32 instance) const {
    const PortState& port = ports_[instance];
    return port.place == kNone || places_[tables_.port_atom[instance]] == port.place ? port.transition : kNone;
  }

  // enabled.cpp
  bool settle_atom(u32 atom, u32 place_before, const LinkedTransition* fired);
  bool run_internals(u32 atom);
  bool find_internal(u32 atom, const LinkedTransition*& found);
  bool move_tokens(u32 atom, const LinkedTransition& transition);
  bool update_ports(u32 atom, u32 place_before);
  bool check_invariants(u32 atom, const LinkedTransition* fired);
  bool move(u32 atom, const LinkedTransition& transition);
  bool is_enabled_from(u32 atom, const LinkedTransition& transition, bool& enabled);
  void set_port(u32 instance, u32 transition);
  void flip(u32 instance, bool on);
  void bump(u32 node, bool on);
  void crossed(u32 node, bool on);
  void touch(u32 atom);
  void mark_dirty(u32 interaction);
  // partial.cpp
  bool begin_port(u32 instance);
  bool settle_partial();
  void note_fault(u64 step, u32 order);
  [[nodiscard]] u64 last_step_of(u32 interaction) const;

  // timed.cpp, timed_ports.cpp, measured.cpp, time_faults.cpp
  void build_time();
  void forget_time();
  void start_clocks(u32 atom);
  bool read_clocks(u32 atom, const Transition* fired);
  bool measure_limits(u32 atom, const TimeGuard& when);
  bool take_limit(u32 atom, const Bound& bound, i64& limit);
  bool interval_of(u32 atom, const TimeGuard& when, Interval& out);
  bool resume_interval(u32 atom, const Resume& resume, Interval& out);
  bool begin_resume(u32 atom, const LinkedTransition* fired);
  bool resume_together(std::vector<u32>& rows);
  bool look_at_time(u32 atom);
  bool look_at_invariants(u32 atom);
  void enable_coming(u32 atom);
  bool begin_timed(u32 instance);
  [[nodiscard]] bool is_in_scope(u32 atom, const Invariant& invariant) const;
  void save_time(std::vector<i64>& out) const;
  void load_time(const std::vector<i64>& in);
  // async.cpp
  [[nodiscard]] const Async* async_of(u32 atom, const LinkedTransition& transition) const;
  bool begin_action(u32 atom, const LinkedTransition& transition, const Async& async);
  void begin_job(u32 atom);
  bool finish_action(u32 atom);
  void restart_jobs();
  // events.cpp
  void list_event_ports();
  [[nodiscard]] u32 event_row(u32 instance) const {
    return time_->event_row.empty() ? kNone : time_->event_row[instance];
  }
  [[nodiscard]] bool is_without_event(u32 instance) const {
    const u32 row = event_row(instance);
    return row != kNone && time_->queues[row].count == 0;
  }
  void take_event(u32 instance);
  bool refuse_events(u32 atom, const u32* transition_of_port);
  bool fail_event(u32 row);
  bool fail_clock(u32 atom, const Clock& clock, const Transition* fired, const char* what, double value);
  // atom_priorities.cpp
  bool hide_ports(u32 atom, u32* transition_of_port);

  // programs.cpp, run_program.cpp
  void build_programs();
  u32 code_row(Code code, u32 zeroed);
  void list_code(u32 connector, Code code, bool zeroes, ProgramCodes& out);
  void list_port(u32 instance, ProgramParts& parts);
  void list_plan(const Plan& plan, ProgramParts& parts);
  bool list_effects(ProgramParts& parts);
  bool list_program(u32 interaction, ProgramParts& parts);
  bool run_codes(const u32* word, u32 count, u32 interaction, bool is_before);
  bool fail_program(std::int32_t status, u32 interaction, bool is_before, u32 index);

  // fire.cpp
  bool fire_parts(const Candidate& candidate);
  bool run_program(const u32* word, u32 interaction);
  bool fire_port(u32 instance);
  bool fire_flat(const InteractionInfo& info);
  bool fire_star(const InteractionInfo& info);
  bool run_transfer(const InteractionInfo& info, u32 clause);
  bool fire_planned(const Candidate& candidate, const InteractionInfo& info);
  bool run_code(Code code, u32 connector);
  void zero_frame(u32 connector);
  [[nodiscard]] u32 chosen_alternative(const Plan& plan, u32 choice) const;
  void bind_choices(const Plan& plan, const PlanUse& use);

  // run_steps.cpp
  template <class Watch>
  u64 run_watched_steps(Prng& prng, u64 limit, bool (*is_stopped)(), bool& sound, Watch& watch);
  void link_steps();

  // run_batch.cpp
  void run_part(const BatchPlan& plan, BatchPart& part, bool records);
  void cut_list(const BatchPlan& plan, std::vector<BatchPart>& parts, u64 draws);
  void join_list(const std::vector<BatchPart>& parts);
  u64 run_shared(const BatchPlan& plan, Prng& prng, u64 draws, std::vector<u32>& fired);

  // search.cpp: configurations of plans
  void look_at_availability(const Plan& plan, u32 root);
  void choose_largest(const Plan& plan, u32 root);
  void choose_bits(const Plan& plan, const u64* bits);
  void bits_of_choice(const Plan& plan, Bits& bits) const;
  bool evaluate(const Plan& plan, u32 root, const Bits& bits, u32& failed);
  bool run_ups(const Plan& plan);
  u32 chosen_clause(const Plan& plan, u32 use);
  bool search(const Plan& plan, u32 root, std::vector<Bits>& found);
  bool search_links(const Plan& plan);
  bool choice_alternatives(const Plan& plan, u32 choice, std::vector<Bits>& found);
  bool initial_configurations(const Plan& plan, u32 root, std::vector<Bits>& out);
  void smaller(const Plan& plan, u32 root, u32 failed, const Bits& bits, std::vector<Bits>& out);
  bool may_hold(const Plan& plan, u32 root, const std::vector<Bits>& largest);
  bool search_ranges(const Plan& plan, u32 root, const std::vector<Bits>& largest, std::vector<Bits>& found);
  bool enumerate(const Plan& plan, std::vector<Bits>& found);
  bool list(u32 interaction);
  void choose(const Candidate& candidate, const Plan& plan);

  // settle.cpp: after a step, what follows from what changed
  bool settle();
  bool settle_priorities();
  bool evaluate_rule_guards();
  bool recompute_component(u32 component);
  void recount(u32 interaction);
  void weigh(u32 interaction);
  u32 base_count(u32 interaction) const;
  void direct_params(u32 interaction, u32 config, std::vector<u32>& out) const;

  // faults
  bool fail(FaultCode code, u32 atom, const Transition* transition, const Transition* other);
  bool fail_code(std::int32_t status, u32 atom, u32 connector, const Transition* transition,
                 const char* rule = nullptr);
  bool fail_invariant(u32 atom, const Invariant& invariant, const Transition* fired);
  bool fail_atom_rules(u32 atom, const std::vector<u32>& rules);
  bool fail_connector(FaultCode code, u32 connector);
  bool fail_rules(const std::vector<u32>& rules);

  Tables tables_;
  CoreOptions options_;
  PriorityTables rules_;
  Fault fault_;

  Span<AtomInfo> atoms_;      // the tables'
  std::vector<u32> places_;   // by atom: automata
  std::vector<u32> history_;  // the interactions fired last, a ring; only for telling stories
  u32 history_at_ = 0;
  std::vector<u64> marks_;
  std::vector<Cell, InCacheLines<Cell>> all_;
  FfiData ffi_data_;
  Binds binds_;  // made when code that needs them may run
  std::vector<PortState> ports_;
  std::vector<std::int32_t> values_;  // by node of the availability network
  DirectInteractions direct_;
  std::vector<u32> rows_;      // by interaction, row_words_ each: its program; kNone: it has none. Made when needed
  std::vector<u32> programs_;  // those longer than a row
  u32 row_words_ = 1;
  bool is_weighted_ = false;        // an interaction may have more than one candidate
  std::vector<ProgramCode> codes_;  // what programs call
  std::map<std::tuple<CodeFn, const void*, u32>, u32> code_rows_;
  EnabledSet enabled_;
  bool keeps_list_ = false;
  std::vector<CompiledRun> runs_;  // the image's runs of step functions
  RunRows run_of_;                 // by interaction: row of runs_, or kNone
  std::vector<u32> step_scratch_;

  std::vector<u32> dirty_;
  std::vector<std::uint8_t> is_dirty_;  // by interaction; empty: all are direct
  std::vector<u32> listing_of_;         // by interaction; kNone: not searched. Empty: none is
  std::vector<Listing> listings_;
  std::vector<FlatGuard> flat_guards_;  // by listing; code == kNone: not that simple

  std::vector<u32> dirty_rules_;
  std::vector<std::uint8_t> is_rule_dirty_;
  std::vector<RuleState> rule_states_;
  std::vector<u32> contributions_;  // by high edge
  std::vector<u32> changed_components_;
  std::vector<std::uint8_t> is_component_changed_;
  std::vector<u32> rule_todo_;
  std::vector<u32> reweigh_;
  std::vector<std::uint8_t> is_reweighed_;

  std::unique_ptr<TimeState> time_;        // null: the image has nothing to do with time
  std::unique_ptr<PartialState> partial_;  // null: steps are taken at once
  bool collects_ = false;                  // a step begins: its ports' actions are not run, but noted

  // scratch
  std::vector<Participant> participant_scratch_;
  std::vector<u32> port_scratch_;
  std::vector<std::uint8_t> rule_holds_;   // by priority of the atom at hand
  std::vector<u32> rule_in_, rule_order_;  // by port of the atom at hand
  std::vector<std::pair<u32, bool>> crossings_;
  std::vector<std::uint8_t> available_, chosen_;  // by plan node
  std::vector<u32> node_scratch_, use_clause_, params_;
  std::vector<std::vector<Bits>> link_alternatives_;  // by plan node: of maximal_only links and choices
  EvaluatedUses evaluated_;
  SearchWork search_work_;
  std::vector<std::pair<u32, u32>> use_stack_;
};

}  // namespace bip::rt
