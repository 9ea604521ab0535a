// Tokens of a .gen file and of the C headers that it includes.
//
// `lex` is linear and never fails: other characters are reported and skipped. The text of a token is a view into the
// source map.
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/source/source.hpp"

namespace bip::genom {

enum class TokenKind : std::uint8_t { Word, Number, String, Sign, End };
struct Token {
  TokenKind kind = TokenKind::End;
  bool starts_line = false;
  std::string_view text;  // of a string: without its quotes
  SourceRange range;
  [[nodiscard]] bool is(std::string_view t) const {
    return text == t && (kind == TokenKind::Word || kind == TokenKind::Sign);
  }
};

/// The last token is End.
[[nodiscard]] std::vector<Token> lex(const SourceMap& sources, FileId file, Diagnostics& diags);

/// A whole number: 0x hex, else decimal even with leading zeros. False if it is none or does not fit 62 bits.
[[nodiscard]] bool whole_number(std::string_view text, std::int64_t& value);

}  // namespace bip::genom
