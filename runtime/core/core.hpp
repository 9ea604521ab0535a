// The core: the only meaning of *enabled* and *fire* (compiler/docs/semantics.md). Engines, explorer, debugger and
// replays all drive it: initialize, look at the candidates, fire one, look again. Faults (R codes) stop it: initialize
// and fire return false, fault() tells why.
//
// Needs an image with code in it, which must outlive it. After a step only the atoms that moved look at their
// transitions, only connectors that watch what changed are looked at again: its cost is proportional to what it
// touched. No allocation in steady state unless a guarded connector is searched.
//
// A facade: what concerns time, events, actions beside the others, partial states and compiled steps is said to the
// part that it belongs to (core_parts.hpp).
#pragma once
#include <vector>

#include "runtime/core/core_parts.hpp"
#include "runtime/core/memory_use.hpp"
#include "runtime/core/programs/take_new_code.hpp"

namespace bip::rt {

class Core {
 public:
  static constexpr u32 kHistory = FiringHistory::kSize;

  explicit Core(const Image& image, CoreOptions options = {}) : parts_(image, options) {}

  /// To the initial state. False: a fault.
  [[nodiscard]] bool initialize() { return parts_.initialize(); }
  /// Before `initialize`, in a run: where the generators of atoms that draw start.
  void seed_draws(u64 seed) { parts_.seed_draws(seed); }

  // ---- candidates, in canonical order
  [[nodiscard]] std::uint64_t candidate_count() const { return parts_.enabled.total(); }
  /// The k-th candidate, k < candidate_count(). O(log interactions).
  [[nodiscard]] Candidate candidate(std::uint64_t k) const { return parts_.candidate(parts_.enabled.select(k)); }
  [[nodiscard]] Candidate candidate(EnabledSet::Position at) const { return parts_.candidate(at); }
  /// Where the k-th candidate is, k < candidate_count(). O(log interactions).
  [[nodiscard]] EnabledSet::Position position(std::uint64_t k) const { return parts_.enabled.select(k); }
  /// Numbers, draws, and the list that the policy `uniform` draws from.
  [[nodiscard]] const EnabledSet& enabled() const { return parts_.enabled; }
  /// Keeps the list from now on, starting in canonical order; `initialize` and `restore` start it anew.
  void keep_list() { parts_.keep_list(); }
  /// Keeps the list and the order of its members from now on: for compiled steps that are chosen by order. Nothing if
  /// they are kept.
  void keep_ordered_list() {
    if (!parts_.enabled.keeps_order()) parts_.keep_ordered_list();
  }
  /// Restores the order that the list had in this state. Has no effect if no list is kept, or if the list is kept in
  /// interaction order.
  void set_list_order(const std::vector<InteractionId>& order) {
    if (parts_.keeps_list && !parts_.enabled.keeps_order())
      parts_.enabled.list(order, static_cast<u32>(tables().interactions.size()));
  }

  // ---- steps
  /// Takes the step. False: a fault; the state is then between two stable ones.
  bool fire(const Candidate& candidate) { return parts_.firing.fire(candidate) && is_sound(); }
  bool fire(std::uint64_t k) { return take(position(k)); }
  /// fire(candidate(at)) by the shortest way. The engine's loop. Of images with time: time().take.
  bool take(EnabledSet::Position at) {
    BIP_ASSERT(parts_.enabled.has(at), "no candidate {} of interaction {}", at.rank, at.interaction);
    return parts_.firing.take(at) && is_sound();
  }
  /// Finds the atom ports that take part, in the order in which they fire.
  void participants(const Candidate& candidate, std::vector<Participant>& out) {
    parts_.firing.participants(candidate, out);
  }
  /// Finds the ports of the connector itself; exported ports of connectors below as such, with this candidate's values:
  /// runs `up`.
  void direct_participants(const Candidate& candidate, std::vector<Participant>& out) {
    parts_.firing.direct_participants(candidate, out);
  }
  [[nodiscard]] const Fault& fault() const { return parts_.fault; }
  /// The interactions fired last.
  [[nodiscard]] const FiringHistory& history() const { return parts_.history; }

  // ---- whole states
  [[nodiscard]] State snapshot() const { return parts_.snapshot(); }
  /// To a state of the same image. Cost: a comparison of the states, plus what differs. False: a fault.
  bool restore(const State& state) { return parts_.restore(state); }
  /// Places, data, clocks and ports of the state, without its candidates: no guard of a connector or a priority is
  /// evaluated. Before the next step comes `restore`. False: a fault.
  bool restore_atoms(const State& state) { return parts_.restore_atoms(state); }

  /// Ends with a fault that another core of the image met.
  void fail(const Fault& fault) { parts_.fault = fault; }
  /// Remembers a step that another core of the image took.
  void remember(InteractionId interaction) { parts_.history.remember(interaction); }

  // ---- looking at the state
  [[nodiscard]] const Cell& cell(VariableId variable) const { return parts_.memory.cells[variable]; }
  /// Of an atom that is away in this core, or gets a value of a port before it takes part.
  void write_cell(VariableId variable, u64 bits) { parts_.memory.cells[variable].bits = bits; }
  [[nodiscard]] bool is_marked(u32 atom, u32 place) const { return parts_.is_marked(atom, place); }
  /// The transition (row of the type's) that the port would fire, or kNone if the port is disabled.
  [[nodiscard]] u32 enabled_transition(u32 atom, u32 port) const;
  [[nodiscard]] bool is_timed() const { return parts_.clocks.is_timed(); }
  /// The instant; 0 in images without time.
  [[nodiscard]] i64 now() const { return parts_.clocks.now(); }

  // ---- what the core was made of
  [[nodiscard]] const Image& image() const { return *parts_.tables.image; }
  [[nodiscard]] const Tables& tables() const { return parts_.tables; }
  [[nodiscard]] const PriorityTables& priorities() const { return parts_.priorities.tables(); }
  /// The image has other code now, which means the same, or compiled steps that it had not. before: its rows as they
  /// were.
  void take_new_code(const std::vector<Code>& before) { rt::take_new_code(parts_, before); }
  [[nodiscard]] MemoryUse memory() const { return memory_use(parts_); }

  // ---- parts
  /// Candidates of single connectors, and the work of searches.
  [[nodiscard]] const InteractionSearch& search() const { return parts_.search; }
  /// Of images with time.
  [[nodiscard]] Clocks& time() { return parts_.clocks; }
  [[nodiscard]] const Clocks& time() const { return parts_.clocks; }
  /// Conditions on clocks apart from the instant, for searches of all instants at once.
  [[nodiscard]] ClockConstraints& clock_constraints() { return parts_.clock_constraints; }
  /// Weights of candidates.
  [[nodiscard]] CandidateWeights& weights() { return parts_.weights; }
  [[nodiscard]] const CandidateWeights& weights() const { return parts_.weights; }
  /// Events from outside.
  [[nodiscard]] EventQueues& events() { return parts_.events; }
  [[nodiscard]] const EventQueues& events() const { return parts_.events; }
  /// Actions that run beside the others.
  [[nodiscard]] AsyncActions& actions() { return parts_.actions; }
  [[nodiscard]] const AsyncActions& actions() const { return parts_.actions; }
  /// Steps begun and finished apart.
  [[nodiscard]] PartialSteps& partial() { return parts_.partial; }
  [[nodiscard]] const PartialSteps& partial() const { return parts_.partial; }
  /// Compiled steps.
  [[nodiscard]] CompiledSteps& steps() { return parts_.steps; }
  [[nodiscard]] const CompiledSteps& steps() const { return parts_.steps; }
  /// All parts, for explanations within runtime/core.
  [[nodiscard]] const CoreParts& parts() const { return parts_; }

 private:
  // True. In checked builds: after comparing what the parts keep with the state.
  [[nodiscard]] bool is_sound() const {
    BIP_ASSERT(parts_.is_consistent(), "of {} interactions", tables().interactions.size());
    return true;
  }

  CoreParts parts_;
};

inline u32 Core::enabled_transition(u32 atom, u32 port) const {
  const u32 row = parts_.ports.enabled_row(tables().port_base(atom) + port);
  return row == kNone ? kNone : row - tables().types[tables().atoms[atom].type].first_transition;
}

}  // namespace bip::rt
