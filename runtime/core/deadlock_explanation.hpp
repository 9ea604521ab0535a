// Why a state is a deadlock, told to a person: who waits for whom, the shortest cycle if there is one.
#pragma once
#include <string>

#include "runtime/core/core.hpp"

namespace bip::rt {

/// Several lines, the last with its newline. The state must have no candidate. Linear in the system.
[[nodiscard]] std::string deadlock_story(const Core& core, std::uint64_t steps, std::uint64_t seed);

}  // namespace bip::rt
