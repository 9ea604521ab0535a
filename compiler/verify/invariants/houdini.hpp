// Lemmas that somebody else found, checked: the largest part of them that no step leaves, together and with what is
// known anyway.
//
// All at once, and again without those that a step enters, until there is none: mostly one question to the solver,
// where finding them took thousands. Nothing rests on where they come from.
#pragma once
#include "compiler/verify/symbolic/ic3.hpp"

namespace bip::verify {

struct InductiveLemmas {
  std::vector<Cube> lemmas;  // in the order of the candidates; inductive with the problem's invariants
  bool is_enough = false;    // no bad state is left
};
/// `candidates`: cubes of bits that the machine has, sorted.
[[nodiscard]] InductiveLemmas houdini(const Ic3Problem& problem, std::vector<Cube> candidates);

/// The same for the solvers: never all of it at once.
[[nodiscard]] std::vector<Signal> clause_of(const Cube& cube, const TransitionSystem& machine);

}  // namespace bip::verify
