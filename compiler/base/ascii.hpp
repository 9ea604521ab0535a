// Classes of ASCII characters, independent of the locale. Source text is UTF-8: bytes of longer characters are in none.
#pragma once

namespace bip {

[[nodiscard]] constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
[[nodiscard]] constexpr bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

}  // namespace bip
