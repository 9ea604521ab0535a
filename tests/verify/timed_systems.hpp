// Small random systems with time: clocks in ns and small constants, so that every instant can be visited.
#pragma once
#include <cstdint>
#include <string>

namespace bip::rt::testing {

/// No clock is compared with or set to more.
inline constexpr std::int64_t kMostConstant = 4;

/// BIP text; compiles for nearly every seed. `more`: components beside the two or three.
[[nodiscard]] std::string random_timed_system(std::uint64_t seed, std::uint64_t more = 0);

}  // namespace bip::rt::testing
