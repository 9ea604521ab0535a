// Expressions of properties by themselves, of any type: what a person asks about a state in a debugging session.
#pragma once
#include <string>

#include "compiler/verify/property/property.hpp"

namespace bip::verify {

/// Parses an expression: `phil[0]@EATS`, `pump.level + 1`. Errors and limits are those of parse_property.
[[nodiscard]] Result<Property> parse_expression(const std::string& text, const System& system);
/// Returns the value of the expression as text: `3`, `true`, `2.5`, `"text"`; of a division that fails, that it does.
[[nodiscard]] std::string value_text(const Property& expression, const rt::Core& core);
/// Is the expression, of type bool, true? Not where a division in it fails.
[[nodiscard]] bool is_true(const Property& expression, const rt::Core& core);

}  // namespace bip::verify
