// The contract of compiled steps: their shapes, runs and operands beside the image's tables.
//
// For assertions after derive_steps: the JIT and emitted C++ compute addresses from these numbers without a look at
// what they find there. Linear in the operands and in the interactions of all runs.
#pragma once
#include <cstdint>

#include "compiler/lower/lower.hpp"

namespace bip::steps {

/// Checks the steps of the system that has so many interactions. Returns true: the rules are assertions of their own.
[[nodiscard]] bool check_steps(const lower::LoweredSystem& lowered, std::uint32_t interactions);

}  // namespace bip::steps
