// Reads and folds constant expressions of IDL (OMG IDL 4.2, 7.4.1.4.3): | ^ & << >> + - * / %, unary + - ~,
// parentheses, literals, names of constants and enumerators, TRUE and FALSE.
//
// Integers are exact, with results of 64 bits, signed or unsigned; an integer beside a floating-point number is
// converted. Recursion is bounded. Linear in the expression, with a lookup per name.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "compiler/genom/constant_value.hpp"
#include "compiler/genom/cursor.hpp"

namespace bip::genom::idl {

/// The constant or enumerator that a name means at this place.
using FindConstant = std::function<std::optional<Value>(const std::string& name)>;

struct ExpressionContext {
  // `~` is taken in so many bits of an unsigned type; 0: of a signed one, where ~x is -x - 1.
  int unsigned_bits = 0;
  bool ends_with_angle = false;    // of `sequence<T, 4>`: outside of parentheses `>` ends it, and there is no `>>`
  bool may_be_enumerator = false;  // a name alone that is not known is no error, but a Value of kind Name
};

/// Folds the expression at `in`, and leaves `in` after it. A value of kind Error if it has none, which is reported
/// (B6008, B6031). Nothing if there is no expression, which is reported (B6000), too.
[[nodiscard]] std::optional<Value> read_constant_expression(Cursor& in, const FindConstant& find,
                                                            const ExpressionContext& context);

}  // namespace bip::genom::idl
