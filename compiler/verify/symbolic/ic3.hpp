// Is a bad state reachable? Property-directed reachability: frames of clauses that over-approximate what n steps reach
// are refined from bad states backwards until two frames agree (a proof) or a bad state is led back to the initial one
// (a way there). Complete for a finite machine, given time.
//
// A. Bradley: SAT-Based Model Checking without Unrolling (2011). N. Een, A. Mishchenko, R. Brayton: Efficient
// Implementation of Property Directed Reachability (2011). What is known to hold always (`invariants`) is assumed in
// every frame.
#pragma once
#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/portfolio/prove_by_invariants.hpp"

namespace bip::verify {

/// Bit rows with values: 2 * row + value. A cube is all of them at once, a lemma says that it never is.
using Cube = std::vector<u32>;
/// May the initial state be one of the cube's?
[[nodiscard]] bool meets_initial(const Cube& cube, const TransitionSystem& machine);

enum class Ic3End : std::uint8_t { Safe, Reached, Stopped };
struct Ic3Problem {
  const TransitionSystem* machine = nullptr;
  Signal bad = kFalse;                          // may depend on the chosen step
  std::vector<std::vector<Signal>> invariants;  // clauses over what is now, true in every reachable state
  CancellationToken cancellation;
  std::function<void(u32 frame, std::size_t lemmas)> report;  // called now and then; may be empty
};
struct Ic3Answer {
  Ic3End end = Ic3End::Stopped;
  std::vector<Cube> lemmas;  // Safe: none of them is ever entered; inductive with the invariants
  std::vector<u32> steps;    // Reached: rows of TransitionSystem::steps from the initial state
  u32 bad_step = kNoRow;     // Reached: the step that is bad itself, if the property is about steps
  u32 frames = 0;
};

[[nodiscard]] Ic3Answer run_ic3(const Ic3Problem& problem);

}  // namespace bip::verify
