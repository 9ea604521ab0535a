// Functions on UTF-8: is a text well-formed, and how many columns does it occupy on a terminal.
#pragma once
#include <cstddef>
#include <optional>
#include <string_view>

namespace bip {

/// Bytes of the well-formed sequence at the start of `text` (1 to 4), 0 if it is not one: overlong forms, surrogates,
/// values past U+10FFFF and cut-off sequences are refused (Unicode 15, table 3-7).
[[nodiscard]] std::size_t utf8_length(std::string_view text);

/// Offset of the first byte that belongs to no well-formed sequence; nullopt if the text is UTF-8.
[[nodiscard]] std::optional<std::size_t> first_bad_utf8(std::string_view text);

/// Terminal columns of the first code point of `text`: 0 for combining marks, 2 for wide East Asian ones, else 1.
/// `text` must not be empty; a malformed byte counts as 1.
[[nodiscard]] unsigned utf8_columns(std::string_view text);

/// Returns whether `text` begins with a control character of the block C1 (U+0080 to U+009F), which terminals obey.
[[nodiscard]] bool is_c1_control(std::string_view text);

/// Returns whether `text` begins with a character that changes the direction in which the text after it is shown
/// (Unicode's property Bidi_Control): what a reader sees is then not what the compiler reads.
[[nodiscard]] bool is_bidi_control(std::string_view text);

}  // namespace bip
