// Escapes of string literals: \b \t \n \f \r \" \' \\ \uXXXX \ooo.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace bip::parse {

struct BadEscape {
  std::uint32_t begin = 0;  // in the body
  std::uint32_t end = 0;
};

/// The literal without its quotes, plain or typographic; a missing closing quote is tolerated.
[[nodiscard]] std::string_view string_body(std::string_view literal);

/// Appends the bytes that `body` stands for to `out`; unknown escapes are kept as written and returned.
[[nodiscard]] std::vector<BadEscape> unescape(std::string_view body, std::string& out);

}  // namespace bip::parse
