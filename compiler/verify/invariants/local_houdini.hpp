// Houdini by parts: filters candidates about one or two components by small questions, one a step and a neighbour.
//
// Whether a step breaks a candidate is asked with what the candidates say of the components that take part in the step
// and of those of the candidate, and with nothing of all others: a question has the size of a few components, whatever
// the size of the system, and what needs a fourth component is lost. Questions that are alike but for the names of
// components have one answer, so the solver is asked about as many as there are kinds of neighbourhoods.
#pragma once
#include <utility>
#include <vector>

#include "compiler/verify/symbolic/ic3.hpp"

namespace bip::verify {

/// Of these signals at most one is true in any reachable state.
struct Exclusion {
  struct Of {
    u32 atom = 0;
    u32 mark = 0;  // says which of the atom's signals it is, in the same way for all atoms of a type
    Signal signal = kFalse;
  };
  std::vector<Of> signals;
};

struct LocalQuestions {
  const TransitionSystem* system = nullptr;
  std::vector<u32> atom_of_port;  // by port instance
  std::vector<u32> type_of_atom;
  std::vector<u32> kind_of_step;  // steps of one kind, with the same ports of atoms of the same types, are alike
  std::vector<Exclusion> exclusions;
};

/// Returns the candidates that remain, in their order: sorted cubes of bits of one or two atoms, none of which contains
/// an initial state. As far as steps of a kind are alike, no step from a state outside of all of them, as `exclusions`
/// and the ranges allow it, leads into one: no proof, but what houdini() is left with has nearly all its candidates
/// inductive. Nothing if the time is over.
[[nodiscard]] std::vector<Cube> keep_locally_inductive(const LocalQuestions& questions, std::vector<Cube> candidates,
                                                       const CancellationToken& cancellation);

}  // namespace bip::verify
