// Evaluates a constant expression of integers: of `#if`, `number:`, `period` and array sizes.
#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "compiler/genom/tokens.hpp"

namespace bip::genom {

/// C's operators over 64-bit numbers; names count as 0. Nothing if it is no such expression, divides by zero, or nests
/// deeper than 100.
[[nodiscard]] std::optional<std::int64_t> constant_value(std::span<const Token> tokens);

}  // namespace bip::genom
