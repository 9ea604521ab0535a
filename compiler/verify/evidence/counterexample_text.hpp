// A way to a bad state, told to a person: the steps as the engine prints them, then what is wrong there.
#pragma once
#include <string>

#include "compiler/verify/portfolio/portfolio.hpp"

namespace bip::verify {

/// What is looked for, as a search has it. `question` must outlive it.
[[nodiscard]] SearchGoal goal_of(const Question& question);

/// The core's state, which breaks the property: `violated[V0002]: …`, and the components that it speaks of.
[[nodiscard]] std::string broken_state(const rt::Core& core, const Property& property, std::size_t steps);

/// Of a decision that is Violated; at most `max_lines` steps. Empty: its choices do not lead to what the question is
/// about.
[[nodiscard]] std::string counterexample_text(const rt::Image& image, const Question& question,
                                              const Decision& decision, std::size_t max_lines);

}  // namespace bip::verify
