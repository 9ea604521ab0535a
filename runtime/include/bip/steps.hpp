// Compiled steps: a whole interaction as one function. The compiler makes one for each shape of interaction (what runs, what
// moves, whose being enabled changes) and lists, for runs of slots that share a shape, where in the core's arrays the
// pieces are: each place, row or slot is an affine function of the number in the run, so tables grow with types, not with
// instances. The core calls them in runs that only draw uniformly (core.hpp, run_steps); emitted C++ and the JIT give the
// functions. No fault, no allocation, no call but of code that is inlined. A program that is compiled with its tables may also
// give a function that takes step after step (step_loop.hpp).
#pragma once
#include <cstdint>

namespace bip::rt {

union Slot;

/// A variable of 32 bits while a loop over steps has the data in columns: an int, a bool as 0 or 1, a row of strings.
struct Cell {
  std::uint32_t bits;
};

/// The core's arrays; a function changes what they hold, and `count`.
struct StepState {
  Slot* all;                 // data
  std::uint32_t* places;     // by atom
  std::int32_t* values;      // of the availability network
  std::uint32_t* members;    // the list of slots that have candidates, `count` long
  std::uint32_t* position;   // by slot: where it is in members, or kAbsentSlot
  std::uint32_t* scratch;    // room for as many as an interaction has parameters
  std::uint32_t count;
  Cell* cells = nullptr;     // data in columns, for the function for many steps of an image that has columns; then `all` rests
};
inline constexpr std::uint32_t kAbsentSlot = 0xffffffffu;

/// A number that is `base` for the first slot of a run and grows by `stride`, modulo 2^32.
struct StepOperand {
  std::uint32_t base, stride;
  [[nodiscard]] constexpr std::uint32_t at(std::uint32_t i) const { return base + stride * i; }
};
using StepFn = void (*)(StepState& state, const StepOperand* operands, std::uint32_t i);
/// Slots first, first + distance, ... (count of them) have the shape and the operands from row `operands` on.
struct StepRun {
  std::uint32_t first, count, distance;
  std::uint32_t shape;
  std::uint32_t operands;
};

/// `count` cells in a row are slots at equal distances: one variable of the atoms of one type.
struct StepColumn {
  std::uint32_t slot, distance, cell, count;
};

/// The slots that fired last: a ring.
struct StepHistory {
  static constexpr std::uint32_t kSize = 1u << 14;
  std::uint32_t* slots;
  std::uint32_t at;
};
struct StepsTaken {
  std::uint64_t count;
  std::uint32_t slot;  // drawn, but not taken: it is none of those that the function knows; or kAbsentSlot
};
class Prng;
/// Draws uniformly and takes steps by itself: `limit` at most, while something is enabled, until it draws a slot it does not know.
using StepsFn = StepsTaken (*)(StepState& state, Prng& prng, StepHistory& history, std::uint64_t limit);

inline void slot_enters(StepState& s, std::uint32_t slot) {
  s.position[slot] = s.count;
  s.members[s.count++] = slot;
}
inline void slot_leaves(StepState& s, std::uint32_t slot) {
  const std::uint32_t at = s.position[slot], last = s.members[--s.count];
  s.members[at] = last;
  s.position[last] = at;
  s.position[slot] = kAbsentSlot;
}
inline void slot_is(StepState& s, std::uint32_t slot, bool on) {
  if ((s.position[slot] != kAbsentSlot) == on) return;
  if (on) slot_enters(s, slot); else slot_leaves(s, slot);
}

}  // namespace bip::rt
