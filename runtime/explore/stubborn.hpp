// Which of a state's slots suffice to reach every deadlock: strong stubborn sets (Valmari 1990; Godefroid 1996).
//
// A set T of slots, one with a candidate among them, such that what is left out can neither move nor be influenced by an
// atom of T's slots: if t in T has a candidate, all slots that could use one of its atoms where that atom stands now are in
// T; if it has none, this holds of one atom whose port is not offered there (of all its atoms, if no single one is to
// blame). Steps outside T then commute with those in T, and what keeps a slot of T disabled only T can change. So a
// deadlock is reached from here exactly if it is through a step of T; each such step is taken, the others are not.
// Kept: which deadlocks are reachable. Not kept: other states, run-time errors, numbers of steps.
#pragma once
#include <vector>

#include "runtime/explore/locals.hpp"
#include "runtime/explore/shapes.hpp"

namespace bip::rt {

struct StubbornScratch {
  std::vector<std::uint32_t> in_set;   // by slot: round in which it was added
  std::uint32_t round = 0;
  std::vector<u32> set, best;
};

class Stubborn {
 public:
  Stubborn(const Core& core, const Shapes& shapes);

  /// has_candidate: by slot, 0 is none. At least one has. `chosen` becomes the slots to take, sorted.
  void choose(const u64* state, const Layout& layout, const Locals& locals, const std::vector<u32>& has_candidate, StubbornScratch& scratch,
              std::vector<u32>& chosen) const;

 private:
  [[nodiscard]] Span<u32> near(const u64* state, const Layout& layout, const Locals& locals, u32 atom) const;
  [[nodiscard]] bool offers(u32 atom, u32 port, u32 place) const;

  const Image& image_;
  const Shapes& shapes_;
  std::vector<u32> place_base_;   // by atom: its first row of by_place_; Petri types have one row
  std::vector<bool> is_automaton_;
  Csr by_place_;                  // by atom and place: slots that may use the atom there
};

}  // namespace bip::rt
