// What an interaction of the candidate order depends on: the atoms whose local states decide its candidates and what
// they do.
//
// Everything that an interaction reads or writes belongs to the atoms of its connector's tree (and to those whose
// exported data it names). So what an interaction offers is a function of the numbers (locals.hpp) of these atoms, and
// can be kept in a table once the core has worked it out. Two things reach further: priorities, which compare
// interactions, and run-time errors in guards of neighbours, which show in the state after a step; both are noted here.
#pragma once
#include <vector>

#include "runtime/core/core.hpp"
#include "runtime/core/link/priorities.hpp"

namespace bip::rt {

enum class InteractionForm : std::uint8_t {
  Moves,  // a rendezvous of automata that only change places: a mask, a value and a change of the state's words
  Table   // a table by the atoms' numbers, filled by the core
};
struct InteractionLeaf {
  u32 atom, port;
  u32 from, to;  // Moves: places
};
struct InteractionShape {
  InteractionForm form = InteractionForm::Table;
  bool is_rendezvous = true;  // all leaves take part: one that is not ready disables it
  Slice atoms;                // rows of Shapes::atoms, sorted: what it depends on
  Slice leaves;               // rows of Shapes::leaves: the possible participants
};
struct Shapes {
  IndexVector<InteractionId, InteractionShape> interactions;
  std::vector<u32> atoms;
  std::vector<InteractionLeaf> leaves;
  /// By atom: the interactions that depend on it.
  InteractionsBy interactions_of_atom;
  /// The core is asked which candidates a state has: rules with guards, rules about parts of a connector, or C++.
  bool needs_core = false;
  /// The model calls C++: nothing is kept, for its functions may remember something.
  bool calls_cpp = false;
  /// Rules without guards, between interactions with one candidate each: by interaction the interactions that hide it.
  /// No rows: no rules.
  CsrOf<InteractionId, InteractionId> dominators;
  /// By interaction: interactions whose guards may fault in the state that a step of this one leads to. No rows:
  /// nothing may.
  CsrOf<InteractionId, InteractionId> watched;

  [[nodiscard]] Span<u32> atoms_of(InteractionId interaction) const {
    return {atoms.data() + interactions[interaction].atoms.first, interactions[interaction].atoms.count};
  }
  [[nodiscard]] Span<InteractionLeaf> leaves_of(InteractionId interaction) const {
    return {leaves.data() + interactions[interaction].leaves.first, interactions[interaction].leaves.count};
  }
};

/// Linear in the image, its hierarchies expanded; rules also by the pairs of interactions that they order.
[[nodiscard]] Shapes shapes_of(const Core& core, MaximalProgress progress);

}  // namespace bip::rt
