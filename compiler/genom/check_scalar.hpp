// Whether a folded value is one of a type: of constants, and of initial values that are not in braces.
#pragma once
#include <string>
#include <string_view>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/genom/idl.hpp"

namespace bip::genom::idl {

/// The type as descriptions write it: "unsigned short", "string", "rover::mode".
[[nodiscard]] std::string type_text(const Type& plain);

/// Reports a value of another kind than the type's (B6032) and an integer that the type does not have (B6010); `what`
/// begins the message. Nothing is reported about None and Error, and about types whose values are not described
/// (native, any).
void check_scalar(const Type& plain, const Value& value, std::string_view what, SourceRange range, Diagnostics& diags);

/// The value of a constant of the type: an integer of a floating-point type is a floating-point number.
[[nodiscard]] Value as_type(const Type& plain, Value value);

}  // namespace bip::genom::idl
