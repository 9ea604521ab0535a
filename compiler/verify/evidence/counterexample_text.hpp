// A counterexample as text for a person: the steps as the engine prints them, then what is wrong at their end.
#pragma once
#include <string>
#include <vector>

#include "compiler/verify/portfolio/decision.hpp"

namespace bip::verify {

/// Describes the core's state, which breaks the property: `violated[V0002]: …`, and the components that the property is
/// about. `steps`: how many led there.
[[nodiscard]] std::string broken_state(const rt::Core& core, const Property& property, std::size_t steps);

/// Describes the core's state, in which these atoms wait for ever: `deadlock[V0004]: …`. `steps`: as above.
[[nodiscard]] std::string stuck_state(const rt::Core& core, const std::vector<u32>& stuck, std::size_t steps);

/// A line for each of the atoms: where it is, and its data.
[[nodiscard]] std::string atoms_text(const rt::Core& core, const std::vector<u32>& atoms);

/// Prints at most `max_lines` steps and their end. Returns an empty text if the choices do not lead to a bad state of
/// the question. The image must have its code. Cost: two replays.
[[nodiscard]] std::string counterexample_text(const rt::Image& image, const Question& question,
                                              const Counterexample& found, std::size_t max_lines);

}  // namespace bip::verify
