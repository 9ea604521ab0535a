// Which of a state's interactions suffice to reach every deadlock: strong stubborn sets (Valmari 1990; Godefroid 1996).
//
// A set T of interactions, one with a candidate among them, such that what is left out can neither move nor be
// influenced by an atom of T's interactions: if t in T has a candidate, all interactions that could use one of its
// atoms where that atom stands now are in T; if it has none, it is because an atom's port is not offered there, and all
// interactions that may bring that atom to where it is offered are in T, or all that could use the atom where it stands
// (if no single atom is to blame: those near all its atoms). Steps outside T then commute with those in T, and what
// keeps an interaction of T disabled only T can change. So a deadlock is reached from here exactly if it is through a
// step of T; each such step is taken, the others are not. Kept: which deadlocks are reachable. Not kept: other states,
// run-time errors, numbers of steps. No proviso about cycles is needed for that (Valmari 1990): a deadlock that can be
// reached from a state can be reached through the state's set.
//
// "t needs u" is a graph over interactions, and T is closed in it. The smallest closed sets with a candidate are
// strongly connected components with no candidate below them (Valmari's algorithm of strong components, by
// runtime/core/graph_algorithms.hpp).
#pragma once
#include <vector>

#include "runtime/core/graph_algorithms.hpp"
#include "runtime/explore/locals.hpp"
#include "runtime/explore/shapes.hpp"

namespace bip::rt {

struct StubbornScratch {
  // A position among the interactions that an interaction needs.
  struct Needed {
    bool is_blocked = false;  // it needs `interactions`, else what is near its atoms
    Span<InteractionId> interactions;
    u32 atom = 0, at = 0;  // position among its atoms, among interactions
  };
  StrongComponents<Needed> search;
  // By interaction that was visited: in the complete components that it needs; once its own is complete, in that too.
  IndexVector<InteractionId, std::uint8_t> has_candidate;
  std::vector<InteractionId> set;
};

class Stubborn {
 public:
  Stubborn(const Core& core, const Shapes& shapes);

  /// has_candidate: by interaction, 0 is none. At least one has. `chosen` becomes the interactions to take, sorted.
  void choose(const u64* state, const Layout& layout, const Locals& locals,
              const IndexVector<InteractionId, u32>& has_candidate, StubbornScratch& scratch,
              std::vector<InteractionId>& chosen) const;

 private:
  [[nodiscard]] Span<InteractionId> near(const u64* state, const Layout& layout, const Locals& locals, u32 atom) const;
  [[nodiscard]] bool offers(u32 atom, u32 port, u32 place) const;
  static std::vector<std::vector<bool>> ports_that_lead(const AtomType& type);
  void list_enabling();
  struct NeedGraph;
  [[nodiscard]] StubbornScratch::Needed needed_by(InteractionId interaction, const u64* state, const Layout& layout,
                                                  const Locals& locals,
                                                  const IndexVector<InteractionId, u32>& has_candidate,
                                                  const StubbornScratch& scratch) const;
  /// None: it needs no further one.
  [[nodiscard]] InteractionId next_needed(InteractionId interaction, StubbornScratch::Needed& needed, const u64* state,
                                          const Layout& layout, const Locals& locals) const;

  const Image& image_;
  const Shapes& shapes_;
  std::vector<u32> place_base_;  // by atom: its first row of by_place_; Petri types have one row
  std::vector<bool> is_automaton_;
  InteractionsBy by_place_;     // by atom and place: interactions that may use the atom there
  std::vector<u32> port_base_;  // by atom: its first row of enabling_
  InteractionsBy enabling_;  // by atom and port: interactions that may bring an automaton to where the port is offered
};

}  // namespace bip::rt
