// Do components wait for ever after a run? Decided by all states that follow it.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "runtime/core/core.hpp"

namespace bip::verify::test {

/// Replays `choices` and visits all states that follow. Returns what is wrong with the claim that each of `atoms` has
/// an enabled port at the end of the run and takes part in no step from there on; empty: nothing, or there are more
/// than `most` states.
[[nodiscard]] std::string check_waiting(const rt::Image& image, const std::vector<std::uint64_t>& choices,
                                        const std::vector<std::uint32_t>& atoms, std::uint64_t most);

}  // namespace bip::verify::test
