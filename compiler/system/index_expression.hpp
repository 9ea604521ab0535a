// Whole numbers that a property writes as `(i + 1) % n`: indices, bounds of ranges.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

namespace bip::system {

/// The value of a name; nothing: it has none.
using ValueOfName = std::function<std::optional<std::int64_t>(std::string_view name)>;

/// Evaluates the expression that begins at text[at], with C's `+ - * / %` of numbers and names and parentheses; `at`
/// ends behind it. Nothing if it has no value: an unknown name, a division by 0, more than 32 bits and their sign.
[[nodiscard]] std::optional<std::int64_t> evaluate_index(std::string_view text, std::size_t& at,
                                                         const ValueOfName& value_of);

}  // namespace bip::system
