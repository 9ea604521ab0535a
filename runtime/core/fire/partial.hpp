// Partial states: atoms may be at work while others go on (Basu, Bidinger, Bozga, Sifakis, "Distributed semantics and
// implementation for systems with interaction and priority", FORTE 2008). A step is *begun* (transfers run, tokens
// move, what takes part offers nothing any more) and each of its atoms is *finished* later, when its action has run
// somewhere else.
//
// Begun in this order, the steps are a run of the sequential semantics: who takes part is in the state that the
// completed steps before left it in, and what else the step depends on must be at rest. That is said in *groups* of
// atoms:
// - of a connector that is no plain rendezvous (a larger interaction might come, or its guard or `up` may fault), all
// atoms
//   below it;
// - of priorities that chain, the atoms of all high sides and of all guards.
// A step may begin if no atom of the groups it depends on is at work. A group with guards, or of what may fault, is
// strict: whoever touches one of its atoms depends on it, so that every state of the group is looked at and its faults
// are the sequential ones.
#pragma once
#include <vector>

#include "runtime/core/fire/fault.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

/// An atom at work: its action runs next. Between begin and finish nobody else looks at the atom's data.
struct Work {
  u32 atom = kNone;
  const LinkedTransition* transition = nullptr;
  u32 internals = 0;  // internal transitions so far
  u64 step = 0;
};
enum class Finished : std::uint8_t { Idle, More, Fault };  // More: the work now names an internal transition

struct PartialState {
  Csr groups_of_interaction;  // those it depends on
  Csr groups_of_atom;
  std::vector<u32> busy_in_group;
  std::vector<u32> own_group;           // by interaction: of its connector, or kNone
  std::vector<u32> group_of_component;  // of priority rules
  Csr atoms_of_interaction;             // all that may take part, sorted
  std::vector<std::uint8_t>
      is_exclusive;  // by interaction: two of its ports are one atom's; it is taken while nothing is at work

  std::vector<u64> last_step;  // by atom
  std::vector<u32> order;      // by atom: in that step
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

  std::vector<u32> held_cells, held_rules;  // scratch
  std::vector<u32> looked_at;
};

/// All atoms that may take part, sorted; one twice if two of its ports may.
void atoms_of_interaction(const Tables& tables, const InteractionInfo& info, std::vector<u32>& out);

struct PriorityTables;
[[nodiscard]] PartialState link_partial(const Tables& tables, const PriorityTables& rules);

}  // namespace bip::rt
