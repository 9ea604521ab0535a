// Houdini: filters candidate lemmas down to the largest subset that is inductive together with what is known.
//
// All candidates are assumed at once; a counterexample to induction refutes each candidate that it leaves; repeat until
// the rest is inductive. The greatest fixpoint, so the result does not depend on the order of counterexamples. Mostly
// one SAT query, where finding the lemmas took thousands. Sound whatever the candidates are.
//
// C. Flanagan, R. Leino: Houdini, an Annotation Assistant for ESC/Java (FME 2001), section 3.
#pragma once
#include "compiler/verify/symbolic/ic3.hpp"

namespace bip::verify {

struct InductiveLemmas {
  std::vector<Cube> lemmas;  // in the order of the candidates; inductive with the problem's invariants
  bool is_enough = false;    // together they exclude all bad states
};
/// As many steps have a solver of their own. Of fewer, encoding the candidates once more takes longer than it saves.
inline constexpr std::size_t kStepsOfBlock = 1024;

/// Consumes the candidates: cubes of bits of the problem's system, sorted. Nothing if the time is over. The result does
/// not depend on `steps_of_block`, which is above 0.
[[nodiscard]] InductiveLemmas houdini(const Ic3Problem& problem, std::vector<Cube> candidates,
                                      std::size_t steps_of_block = kStepsOfBlock);

/// Returns the clause of a lemma: the negation of its cube.
[[nodiscard]] std::vector<Signal> clause_of(const Cube& cube, const TransitionSystem& system);

}  // namespace bip::verify
