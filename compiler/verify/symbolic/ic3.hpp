// IC3 / PDR: decides whether a bad state of a transition system is reachable.
//
// Frames F_0, F_1, … are sets of clauses; F_k over-approximates the states that are reachable in at most k steps. Bad
// states of the last frame become proof obligations, which are blocked by clauses that are inductive relative to the
// frame before, or lead back to an initial state (a counterexample). Two equal frames are an inductive invariant (a
// proof). Complete for a finite system, given time. Invariants that are known to hold strengthen every frame.
//
// A. Bradley: SAT-Based Model Checking without Unrolling (VMCAI 2011). N. Eén, A. Mishchenko, R. Brayton: Efficient
// Implementation of Property Directed Reachability (FMCAD 2011). Departures are listed in ic3.cpp.
#pragma once
#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/portfolio/prove_by_invariants.hpp"

namespace bip::verify {

/// A conjunction of literals over state bits, sorted, each bit at most once; literal 2 * bit + value. A lemma is the
/// negation of a cube: a clause.
using Cube = std::vector<u32>;
[[nodiscard]] constexpr u32 cube_bit(u32 cube_literal) { return cube_literal / 2; }
[[nodiscard]] constexpr bool cube_value(u32 cube_literal) { return (cube_literal & 1) != 0; }
[[nodiscard]] constexpr u32 cube_literal_of(u32 bit, bool value) { return 2 * bit + (value ? 1 : 0); }
/// Does the cube contain an initial state? Bits without a known initial value may have either.
[[nodiscard]] bool meets_initial(const Cube& cube, const TransitionSystem& system);

enum class Ic3End : std::uint8_t { Safe, Reached, Stopped };
struct Ic3Problem {
  const TransitionSystem* system = nullptr;
  Signal bad = kFalse;                          // may depend on the chosen step
  std::vector<std::vector<Signal>> invariants;  // clauses over current values, true in every reachable state
  // What every step obeys besides; it may depend on inputs. A step that does not is none.
  Signal constraint = kTrue;
  std::vector<Signal> observed;  // a counterexample has the inputs of these as well
  // By bit: is it followed? The others are inputs that may have, in each state anew, any value that the invariants
  // allow (localization reduction, localized_ic3.hpp). Empty: all are. Otherwise whole atoms, and all bits on which
  // `bad` depends.
  std::vector<std::uint8_t> followed;
  CancellationToken cancellation;
  std::function<void(u32 frame, std::size_t lemmas)> report;  // called every 64 queries; may be empty
};
struct Ic3Answer {
  Ic3End end = Ic3End::Stopped;
  std::vector<Cube> lemmas;  // Safe: cubes that are never entered; inductive together with the invariants
  std::vector<u32> steps;    // Reached: rows of TransitionSystem::steps from the initial state
  u32 bad_step = kNoRow;     // Reached: the step that is bad itself, if the property is about steps
  // Reached, if the problem has observed signals: of the first state what is not known of all initial ones, and by step
  // the inputs that are 1. They determine the values of all signals in question.
  Cube first;
  std::vector<std::vector<Signal>> inputs;
  // Reached, if not all bits are followed: what each state on the way has to be, from the first to the bad one, with
  // the bits that are not followed.
  std::vector<Cube> required;
  u32 frames = 0;
};

/// Runs until an answer or the problem is cancelled. Cost: one SAT query per generalised literal and propagated lemma.
[[nodiscard]] Ic3Answer run_ic3(const Ic3Problem& problem);

}  // namespace bip::verify
