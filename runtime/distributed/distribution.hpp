// The roles of nodes in a distributed run: the node at which each atom is at home, and the node that coordinates each
// interaction.
//
// Interactions that can compete for an atom form a *conflict set*, and one node coordinates all of a set, so that
// nothing is ever reserved. Two interactions compete
// - if an atom offers ports of both from one place, and nothing is known that tells them apart (NextMove);
// - if one of them depends on a group (core/fire/partial.hpp: a larger interaction, a rule, or a fault might come) and
//   the other moves an atom of that group.
// So an atom at rest has at most one coordinator: the only node to which it is offered. No step depends on what is
// known of next moves: an atom is offered to one node, which alone begins what moves it. If it were wrong, a step that
// is possible would not be begun.
//
// A set that is too large for one node is *split* (split_sets.hpp): each of its interactions has a coordinator of its
// own, and an atom that interactions of several coordinators can take from one state stays offered at its home, which
// gives it to one attempt after the other, as a lock.
//
// Linear in the ports of all interactions and groups, but for the logarithms of sorting. Constant during a run.
#pragma once
#include <compare>
#include <string>
#include <vector>

#include "runtime/core/link/priorities.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

inline constexpr u32 kMostNodes = 64;
/// Conflict sets of more interactions are split, unless a placement says otherwise.
inline constexpr u32 kSplitAbove = 1000;
inline constexpr u32 kSplitNone = kNone;

/// What is known of an atom beyond its places (compiler/verify/conflicts): in one of its modes at the place, with this
/// history, it offers this port, among others to this connector. Its history is the last connector that moved it
/// through one of its ports that have rows with connectors. Of an atom with rows these are all: it never does anything
/// else.
struct NextMove {
  u32 atom = 0, place = 0;
  u32 history = kNone;    // a connector; kNone: there was none yet
  u32 mode = 0;           // what can be offered together has one number
  u32 port = 0;           // of the atom's type
  u32 connector = kNone;  // kNone: all of the port
  friend auto operator<=>(const NextMove&, const NextMove&) = default;
};

/// Where the atoms are at home.
struct Placement {
  std::vector<std::string> nodes;           // their names
  std::vector<u32> home;                    // by atom
  std::vector<std::string> addresses = {};  // by node: HOST:PORT, or empty; of a placement without a file: none
  std::vector<NextMove> next_moves = {};    // sorted by atom, place, history, mode; of other atoms places tell all
  u32 split_above = kSplitAbove;            // interactions: larger conflict sets are split; kSplitNone: none is
  std::vector<u64> counts = {};             // by interaction: how often it was taken, for reports; empty: unknown
};

/// Variables that connectors and rules read or write, and traces show: rows in `all`, by atom. What an offer carries.
[[nodiscard]] VariablesBy shown_cells(const Tables& tables);

struct ConflictSets {
  u32 count = 0;
  IndexVector<InteractionId, u32> of_interaction;
  InteractionsBy interactions;   // by set
  Csr atoms;                     // by set: those that take part or are looked at, sorted
  std::vector<u32> first_place;  // by atom: row of its first place in set_at; and one more
  std::vector<u32> set_at;       // by atom and place (of Petri types: one for all): the set it is offered to, or kNone
  /// Of atoms with next moves: the set of what an enabled port leads to.
  struct Situation {
    u32 atom = 0, place = 0, history = kNone, port = 0, set = kNone;
  };
  std::vector<Situation> situations;        // sorted by atom, place, history, port
  std::vector<std::uint8_t> by_situation;   // by atom: not 0 if set_at does not tell its set
  std::vector<std::uint8_t> is_told_apart;  // by port instance: its connector becomes the atom's history
  [[nodiscard]] u32 set_of(u32 atom, u32 place) const { return set_at[row_of_place(atom, place)]; }
  /// The set of an atom by_situation that offers the port; kNone: no interaction can take it through that port.
  [[nodiscard]] u32 set_of(u32 atom, u32 place, u32 history, u32 port) const {
    const u32 row = situation_of(atom, place, history, port);
    return row == kNone ? kNone : situations[row].set;
  }
  /// The row of situations of an atom by_situation that offers the port; kNone: no interaction can take it through that
  /// port.
  [[nodiscard]] u32 situation_of(u32 atom, u32 place, u32 history, u32 port) const;
  /// The row of set_at.
  [[nodiscard]] u32 row_of_place(u32 atom, u32 place) const {
    const u32 first = first_place[atom];
    return first_place[atom + 1] - first == 1 ? first : first + place;
  }
};
[[nodiscard]] ConflictSets conflict_sets(const Tables& tables, const PriorityTables& rules,
                                         const std::vector<NextMove>& next_moves = {});

/// A variable that holds a C++ object, is seen by an interaction, and would have to cross from one node to another.
struct CrossingObject {
  u32 atom = kNone;
  u32 variable = kNone;   // of the atom's type
  u32 other = kNone;      // an atom at home elsewhere that ends up in one interaction with it
  InteractionId meeting;  // of both; or, where a chain of interactions joins them, of the other one
};

struct Distribution {
  Placement placement;
  ConflictSets sets;
  VariablesBy cells;                   // shown_cells
  std::vector<u32> coordinator;        // by set; of a split set: where most of its ports are at home
  std::vector<std::uint8_t> is_split;  // by set: not 0 if its interactions have several coordinators
  IndexVector<InteractionId, u32> coordinator_of;
  std::vector<u32> offered_at;  // by row of sets.set_at: the node to which the atom is offered, or kNone
  std::vector<u32> offered_in;  // by row of sets.situations: the same
  RowsByInteraction locks;      // the atoms that are locked for it at their homes, in the order of homes
  RowsByInteraction needs;  // of an interaction of a split set: what must be offered in one core to begin it, sorted
  std::vector<CrossingObject> crossing;  // not empty: such a run cannot be
  std::vector<u32> history;              // by atom: NextMove::history when the run goes on; empty: it begins
  bool may_fault = false;                // can the guards or `up`s of connectors, or rules, end in a fault?

  [[nodiscard]] u32 home(u32 atom) const { return placement.home[atom]; }
  /// The node to which an atom that is not by_situation is offered at this place; kNone: no interaction can take it
  /// there.
  [[nodiscard]] u32 coordinator_at(u32 atom, u32 place) const { return offered_at[sets.row_of_place(atom, place)]; }
};

/// Places atoms breadth first along interactions, in pieces of equal size; atoms whose C++ objects may not cross stay
/// with those that they meet. Nodes are named "1", "2", …
[[nodiscard]] Placement place_atoms(const Tables& tables, const PriorityTables& rules, u32 nodes);
/// By atom: one of those that it must be with, as C++ objects that interactions see may not cross.
[[nodiscard]] std::vector<u32> atoms_together(const Tables& tables, const PriorityTables& rules);
/// Why interactions of a set are in it: one of them, or one rule, joins so many.
struct JoinReason {
  enum class Kind : std::uint8_t { Place, Connector, Rule };
  Kind kind = Kind::Place;
  u32 row = kNone;                    // Place: the atom; Connector: an interaction; Rule: a priority
  u32 place = kNone;                  // Place: of the atom's type
  std::vector<InteractionId> joined;  // ascending
};
/// The reason that joins the most interactions of the set.
[[nodiscard]] JoinReason why_joined(const Tables& tables, const PriorityTables& rules, const ConflictSets& sets,
                                    u32 set);

/// Does an image have C++ classes from which events come?
[[nodiscard]] bool has_event_sources(const Image& image);
/// What several nodes do not run of models with time, why not, and the way out.
struct TimeOnNodes {
  std::string problem, why, help;  // empty: they do
  SourceLine loc = {};             // of a connector type, port or transition that is the reason; line 0: unknown
  SourceLine open_bound = {};      // if `loc` is an eager transition's: of the transition with the bound
};
[[nodiscard]] TimeOnNodes time_on_nodes(const Image& image);

/// Gives each conflict set to the node at which most of its ports are at home, or where its C++ objects are, and splits
/// those that are too large.
[[nodiscard]] Distribution distribute(const Tables& tables, const PriorityTables& rules, Placement placement);

}  // namespace bip::rt
