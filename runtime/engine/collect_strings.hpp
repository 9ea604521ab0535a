// Frees strings that were made at run time and that no state refers to any more.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "runtime/core/core.hpp"

namespace bip::rt {

/// Rows of strings that are in use. Conservative: every number that could be the row of a string is one.
class LiveStrings {
 public:
  /// Of the cells and the queues of events.
  void add(const Core& core);
  /// Of the bits of cells: of a state, of a message between nodes.
  void add(const std::vector<u64>& cells);
  /// Frees all others.
  void keep_only(FfiContext& ffi);
  /// Keeps them for ever.
  void pin(FfiContext& ffi) const;

 private:
  std::vector<std::int32_t> rows_;
};

/// Returns whether so many strings were made since the last time that it pays to free them. Cost: a comparison.
[[nodiscard]] bool wants_collection(const Image& image);

/// Frees strings if that pays. Requires that no step and no evaluation is under way. Copies of states do not count:
/// code that makes one calls pin_strings(). Cost: a comparison; amortised constant per string.
void collect_strings(Core& core);

/// Keeps the strings of the core's state for ever, for a copy of it. Linear in the cells of models that make strings.
void pin_strings(const Core& core);

/// Steps that are taken in bulk, of `steps` that are wanted, before the next call of collect_strings(): fewer in models
/// that can make strings, so that their memory stays bounded.
[[nodiscard]] inline u64 steps_before_collection(const Core& core, u64 steps) {
  constexpr u64 kStepsPerCollection = u64{1} << 12;
  return core.image().ffi == nullptr ? steps : std::min(steps, kStepsPerCollection);
}

}  // namespace bip::rt
