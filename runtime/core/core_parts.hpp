// The parts of a core, and what concerns all of them: the initial state, settling after a step, snapshot and restore.
//
// Each part owns its own state and reaches the others through the CoreParts that holds them; plain data that all of
// them read and write (tables, memory, fault) stand here. Users of a core include core.hpp.
#pragma once
#include <vector>

#include "runtime/core/fire/async_actions.hpp"
#include "runtime/core/fire/event_queues.hpp"
#include "runtime/core/fire/fault.hpp"
#include "runtime/core/fire/fault_reporter.hpp"
#include "runtime/core/fire/firing.hpp"
#include "runtime/core/fire/firing_history.hpp"
#include "runtime/core/fire/partial.hpp"
#include "runtime/core/link/candidate_weights.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/core/programs/compiled_steps.hpp"
#include "runtime/core/programs/step_programs.hpp"
#include "runtime/core/search/interaction_search.hpp"
#include "runtime/core/state/atom_priorities.hpp"
#include "runtime/core/state/atom_steps.hpp"
#include "runtime/core/state/enabled_set.hpp"
#include "runtime/core/state/port_states.hpp"
#include "runtime/core/state/priority_state.hpp"
#include "runtime/core/state/state.hpp"
#include "runtime/core/state/state_memory.hpp"
#include "runtime/core/time/clock_constraints.hpp"
#include "runtime/core/time/clocks.hpp"

namespace bip::rt {

struct CoreParts {
  CoreParts(const Image& image, const CoreOptions& how);
  CoreParts(const CoreParts&) = delete;
  CoreParts& operator=(const CoreParts&) = delete;

  [[nodiscard]] const Image& image() const { return *tables.image; }
  [[nodiscard]] bool is_marked(u32 atom, u32 place) const;
  [[nodiscard]] Candidate candidate(EnabledSet::Position at) const;
  /// Returns the row of the candidate's configuration: among what is listed, hidden ones as well.
  [[nodiscard]] u32 config_of(EnabledSet::Position at) const;
  [[nodiscard]] bool looks_at_binds() const {
    return tables.any_searched || priorities.tables().count != 0 || clocks.is_timed() || image().choices.size != 0;
  }

  /// To the initial state. False: a fault.
  bool initialize();
  /// The generators of atoms that draw start anew with the next initial state. Before it is called they are of no run.
  void seed_draws(u64 seed) {
    draw_seed = seed;
    has_draw_seed = true;
  }
  [[nodiscard]] State snapshot() const;
  /// To a state of the same image. Cost: a comparison of the states, plus what differs. False: a fault.
  bool restore(const State& state);
  /// The same without what connectors and priorities make of it: `settle` is due.
  bool restore_atoms(const State& state);
  /// Is there nothing for `settle` to do before candidates are looked at?
  [[nodiscard]] bool is_settled() const {
    return ports.dirty().empty() && (priorities.tables().count == 0 || priorities.is_settled());
  }
  /// After a step: lists the candidates of the interactions that were marked, then what priorities make of them, then
  /// the enabled set. Order does not matter to the result: everything here is a function of the state. False: a fault.
  bool settle() {
    if (!is_settled() && !settle_marked()) return false;
    enabled.settle_list();
    return true;
  }
  /// Keeps the list of the enabled from now on, starting in canonical order.
  void keep_list();
  /// Keeps the list and the order of its members from now on.
  void keep_ordered_list();
  /// Is what the parts keep what the state says? For assertions between steps. Systems of more than 64 interactions or
  /// atoms are not looked at: true.
  [[nodiscard]] bool is_consistent() const;

  Tables tables;
  CoreOptions options;
  Fault fault;
  Span<AtomInfo> atoms;  // the tables'
  StateMemory memory;
  EnabledSet enabled;
  bool keeps_list = false;
  bool has_state = false;  // else as `reset` leaves it
  u64 draw_seed = 0;
  bool has_draw_seed = false;

  FaultReporter faults{*this};
  FiringHistory history;
  PortStates ports{*this};
  AtomSteps atom_steps{*this};
  AtomPriorities atom_priorities{*this};
  InteractionSearch search{*this};
  PriorityState priorities;
  Firing firing{*this};
  StepPrograms programs{*this};
  CompiledSteps steps{*this};
  Clocks clocks{*this};
  ClockConstraints clock_constraints{*this};
  EventQueues events{*this};
  AsyncActions actions{*this};
  PartialSteps partial{*this};
  CandidateWeights weights{*this};

 private:
  void reset();
  bool settle_anew();
  bool settle_marked();
};

// ---- what is inlined into the engine's loop
inline u32 PortStates::enabled_row(u32 instance) const {
  const PortState& port = ports_[instance];
  return port.place == kNone || core_.memory.places[core_.tables.port_atom[instance]] == port.place ? port.transition
                                                                                                    : kNone;
}

inline u32 CoreParts::config_of(EnabledSet::Position at) const {
  return search.is_searched(at.interaction) ? search.config_of(at.interaction, at.rank) : at.rank;
}

inline bool Firing::take(EnabledSet::Position at) {
  const u32* program = core_.programs.program_of(at.interaction);
  if (*program != kNone) return core_.programs.run(program, at.interaction);
  // The rest of a Candidate is for those who look at it: to fire it takes no look-up.
  return fire_parts({.interaction = at.interaction, .config = core_.config_of(at)});
}

}  // namespace bip::rt
