// A way through the transition system taken by the engine: each step must be a candidate of the core there.
#pragma once
#include <optional>

#include "compiler/verify/symbolic/transition_system.hpp"
#include "runtime/core/core.hpp"

namespace bip::verify {

/// The numbers of the candidates taken from the initial state; nothing if the core does not go that way (the transition
/// system is imprecisions).
[[nodiscard]] std::optional<std::vector<std::uint64_t>> replay_steps(const rt::Image& image,
                                                                     const TransitionSystem& transition_system,
                                                                     const std::vector<std::uint32_t>& steps);

/// The same where the last step ends in a run-time error, at once or in the state that it leads to.
[[nodiscard]] std::optional<std::vector<std::uint64_t>> replay_to_fault(const rt::Image& image,
                                                                        const TransitionSystem& transition_system,
                                                                        const std::vector<std::uint32_t>& steps);

/// The candidate of the core's state that is the transition system's step, if there is one.
[[nodiscard]] std::optional<std::uint64_t> candidate_of(rt::Core& core, const SystemStep& step);

}  // namespace bip::verify
