// Compiled steps: a whole interaction as one function. The compiler makes one for each shape of interaction (what runs,
// what moves, whose being enabled changes) and lists, for runs of interactions that share a shape, where in the core's
// arrays the pieces are: each place, row or interaction is an affine function of the number in the run, so tables grow
// with types, not with instances. The core calls them in runs without a trace or a callback (CompiledSteps::run);
// emitted C++ and the JIT provide the functions. No fault, no allocation, no call but of code that is inlined. A
// program that is compiled with its tables may also give a function that takes step after step (step_loop.hpp).
#pragma once
#include <cstdint>

#include "bip/contract.hpp"
#include "bip/rows.hpp"

namespace bip::rt {

union Cell;

/// A variable of 32 bits while a loop over steps has the data in columns: an int, a bool as 0 or 1, a row of strings.
struct ColumnCell {
  std::uint32_t bits;
};

/// The core's arrays; a function changes what they hold, and `count`.
struct StepState {
  Cell* all;                // data
  std::uint32_t* places;    // by atom
  std::int32_t* values;     // of the availability network
  std::uint32_t* members;   // the list of interactions that have candidates, `count` long
  std::uint32_t* position;  // by interaction: where it is in members, or kAbsentInteraction
  std::uint32_t* scratch;   // room for as many as an interaction has parameters
  std::uint32_t count;
  ColumnCell* cells =
      nullptr;  // data in columns, for the function for many steps of an image that has columns; then `all` rests
};
inline constexpr std::uint32_t kAbsentInteraction = 0xffffffffu;

/// A number that is `base` for the first interaction of a run and grows by `stride`, modulo 2^32.
struct StepOperand {
  std::uint32_t base, stride;
  [[nodiscard]] constexpr std::uint32_t at(std::uint32_t i) const { return base + stride * i; }
};
using StepFn = void (*)(StepState& state, const StepOperand* operands, std::uint32_t i);
/// Interactions first, first + distance, ... (count of them) have the shape and the operands from row `operands` on.
struct StepRun {
  std::uint32_t first, count, distance;
  std::uint32_t shape;
  std::uint32_t operands;
};

/// A step of the shape may put interactions into the list: the one of operand `operand`, or as many as operand
/// `repeats` says, each `stride` after the one before.
struct StepEntry {
  static constexpr std::uint32_t kOnce = 0xffffffffu;  // no operand
  std::uint32_t shape, operand, repeats, stride;
};

/// `count` column cells in a row are cells at equal distances: one variable of the atoms of one type.
struct StepColumn {
  std::uint32_t cell, distance, column_cell, count;
};

/// The interactions that fired last: a ring.
struct StepHistory {
  static constexpr std::uint32_t kSize = 1u << 14;
  std::uint32_t* interactions;
  std::uint32_t at;
};
struct StepsTaken {
  std::uint64_t count;
  std::uint32_t
      interaction;  // drawn, but not taken: it is none of those that the function knows; or kAbsentInteraction
};
class Prng;
/// Draws uniformly and takes steps by itself: `limit` at most, while something is enabled, until it draws an
/// interaction it does not know.
using StepsFn = StepsTaken (*)(StepState& state, Prng& prng, StepHistory& history, std::uint64_t limit);

/// Each step is the first candidate that is interaction `from` or greater, cyclically. `follows`: `from` is then the
/// one after that.
struct StepOrder {
  static constexpr std::uint32_t kShort = 8;
  std::uint32_t from = 0;
  bool follows = false;
};
/// The same with the choice by order. Ends also if more than StepOrder::kShort interactions are enabled: a short list
/// is searched.
using OrderedStepsFn = StepsTaken (*)(StepState& state, StepOrder& order, StepHistory& history, std::uint64_t limit);

/// Steps on arrays in another order, for long runs of models whose own order has no regularity. Tables by inner number
/// say which of the core's it is. A run has the interactions that run_of assigns to it, from `first` on, at distance 1.
struct InnerSteps {
  Span<std::uint32_t> atoms, interactions, cells;
  Span<std::uint32_t> run_of;  // by inner interaction; kNone: it cannot fire; then, if steps need it, scratch
  Span<StepRun> runs;
  std::uint32_t pay = 0;       // after so many steps filling the arrays has paid
  StepsFn steps_fn = nullptr;  // takes many of them; what it does step_fns do, too
};

inline void interaction_enters(StepState& s, std::uint32_t interaction) {
  BIP_ASSERT(s.position[interaction] == kAbsentInteraction, "interaction {} is in the list already", interaction);
  s.position[interaction] = s.count;
  s.members[s.count++] = interaction;
}
inline void interaction_leaves(StepState& s, std::uint32_t interaction) {
  BIP_ASSERT(s.count != 0 && s.position[interaction] < s.count && s.members[s.position[interaction]] == interaction,
             "interaction {} is not at {}", interaction, s.position[interaction]);
  const std::uint32_t at = s.position[interaction], last = s.members[--s.count];
  s.members[at] = last;
  s.position[last] = at;
  s.position[interaction] = kAbsentInteraction;
}
inline void set_interaction(StepState& s, std::uint32_t interaction, bool on) {
  if ((s.position[interaction] != kAbsentInteraction) == on) return;
  if (on) interaction_enters(s, interaction);
  else interaction_leaves(s, interaction);
}

/// Puts the interaction in or takes it out, as its value says, without branches: they are not predictable. Writes
/// beyond the list's end.
inline void settle_interaction(StepState& s, std::uint32_t interaction) {
  const std::uint32_t count = s.count, position = s.position[interaction];
  // All ones if so: it is not available, it is in the list, it leaves.
  const auto off = static_cast<std::uint32_t>(s.values[interaction] >> 31);
  const std::uint32_t was = position != kAbsentInteraction ? ~0u : 0u;
  const std::uint32_t leaves = was & off;
  s.members[count] = interaction;
  const std::uint32_t end = count + leaves, last = s.members[end];
  const std::uint32_t hole = count ^ ((count ^ position) & leaves);
  s.members[hole] = last;
  s.position[last] = hole;
  s.position[interaction] = (position & was) | (count & ~was) | off;
  s.count = end - ~(was | off);
}

}  // namespace bip::rt
