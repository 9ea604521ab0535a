// The parser of rules (parse_rules.cpp) and of their conditions (parse_condition.cpp). Internal to compiler/rules.
#pragma once
#include "compiler/genom/cursor.hpp"
#include "compiler/rules/rules.hpp"

namespace bip::rules {

/// NAME [ '.' NAME ]
[[nodiscard]] bool parse_path(genom::Cursor& at, Path& into, const char* what);
/// NUMBER ( ticks | us | ms | s | min )
[[nodiscard]] bool parse_span(genom::Cursor& at, genom::Span& into);
/// Digits, a dot, digits; at most four on either side.
[[nodiscard]] bool is_decimal(std::string_view text);
/// C's operators over what is active, done, fresh, asked for.
[[nodiscard]] bool parse_condition(genom::Cursor& at, Expr& into);

}  // namespace bip::rules
