// The loop of compiled steps, for programs that know their runs of interactions when they are compiled: a draw, then
// code that is inlined with its operands as constants. It is inlined itself, into a function that may be made for
// several processors. Half the instructions of what the core does by tables, one step after the other
// (core/run_steps.cpp): the same draws, the same steps.
#pragma once
#include <cstdint>

#include "bip/prng.hpp"
#include "bip/steps.hpp"

#if defined(__GNUC__)
#define BIP_INLINE [[gnu::always_inline]] inline
#define BIP_INLINED __attribute__((always_inline))  // a lambda
#else
#define BIP_INLINE inline
#define BIP_INLINED
#endif

namespace bip::rt {

/// Is the interaction one of `count` from `first` on at equal distances? Then `number` is which.
constexpr bool is_in_run(std::uint32_t interaction, std::uint32_t first, std::uint32_t count, std::uint32_t distance,
                         std::uint32_t& number) {
  const std::uint32_t offset = interaction - first;
  if (offset >= count * distance || offset % distance != 0) return false;
  number = offset / distance;
  return true;
}

/// For a function that is not inlined: what the loop has at hand stays out of memory.
inline void call_step(StepFn step, StepState& s, const StepOperand* operands, std::uint32_t number) {
  StepState copy = s;
  step(copy, operands, number);
  s.count = copy.count;
}

/// See StepsFn. `take(state, interaction)` takes a step, or returns false if it does not know the interaction.
template <class Take>
BIP_INLINE StepsTaken take_steps(StepState& state, Prng& prng, StepHistory& history, std::uint64_t limit, Take take) {
  StepState s = state;
  Prng numbers = prng;
  std::uint32_t at = history.at, interaction = kAbsentInteraction;
  std::uint64_t taken = 0;
  while (taken < limit && s.count != 0) {
    interaction = s.members[s.count == 1 ? 0 : numbers.below(s.count)];
    if (!take(s, interaction)) break;
    history.interactions[at] = interaction;
    at = (at + 1) % StepHistory::kSize;
    interaction = kAbsentInteraction;
    ++taken;
  }
  state.count = s.count;
  prng = numbers;
  history.at = at;
  return {taken, interaction};
}

}  // namespace bip::rt
