// The end that a model declares: each atom is at `final` places. Whether there is a candidate is the caller's to know.
#pragma once
#include <string>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"

namespace bip::rt {

/// Returns whether each atom has a final place, so that a state can be final at all. Linear in the atoms.
[[nodiscard]] bool has_final_states(const Image& image);

/// Returns whether the atom is marked at final places only.
[[nodiscard]] bool is_at_final_places(const Core& core, u32 atom);

/// Returns whether some port of the atom has an enabled transition and the atom is not at final places only. If not, it
/// has terminated, or waits for time.
[[nodiscard]] bool wants_to_move(const Core& core, u32 atom);

/// Returns whether each atom is marked at final places only. Linear in the places of all atoms, or less.
[[nodiscard]] bool is_final_state(const Core& core);

/// Returns whether the state, of an image without time, has no candidate and is not final.
[[nodiscard]] inline bool is_deadlock(const Core& core) { return core.candidate_count() == 0 && !is_final_state(core); }

/// Returns how a run ends in a state that no step leaves: Final or Deadlock.
[[nodiscard]] inline End end_without_step(const Core& core) {
  return is_final_state(core) ? End::Final : End::Deadlock;
}
/// The text of that end: final_line or deadlock_story.
[[nodiscard]] std::string end_story(const Core& core, std::uint64_t steps, std::uint64_t seed);

/// One line: `final: each component is at a final place   (5 steps, seed 4)`.
[[nodiscard]] std::string final_line(std::uint64_t steps, std::uint64_t seed);

}  // namespace bip::rt
