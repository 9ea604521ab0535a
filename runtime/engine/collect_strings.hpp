// Frees strings that were made at run time and that no state refers to any more.
#pragma once
#include <algorithm>

#include "runtime/core/core.hpp"

namespace bip::rt {

/// Frees strings if enough were made since the last time. Conservative: every number in a cell or in a queue of events
/// that could be the row of a string keeps it. Requires that no step and no evaluation is under way. Copies of states
/// do not count: code that makes one pins the strings (FfiContext::pin). Cost: a comparison; amortised constant per
/// string.
void collect_strings(Core& core);

/// Steps that are taken in bulk, of `steps` that are wanted, before the next call of collect_strings(): fewer in models
/// that can make strings, so that their memory stays bounded.
[[nodiscard]] inline u64 steps_before_collection(const Core& core, u64 steps) {
  constexpr u64 kStepsPerCollection = u64{1} << 12;
  return core.image().ffi == nullptr ? steps : std::min(steps, kStepsPerCollection);
}

}  // namespace bip::rt
