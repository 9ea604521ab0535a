// A random property of a system's states, for the tests of the prover.
#pragma once
#include <cstdint>
#include <string>

#include "compiler/system/system.hpp"

namespace bip::verify::test {

/// "never a@P && b.x > 2": neither always nor never broken, with some luck. The same seed gives the same text.
[[nodiscard]] std::string random_property(const System& system, std::uint64_t seed);

}  // namespace bip::verify::test
