// The tokens of one file, after the lexer and the classification of words that depend on context.
//
// A token has a type of the grammar and a byte range; comments are kept separately. Lexical errors are reported here,
// and the tokens concerned are dropped or repaired, so that the parser can continue. Linear in the text.
#pragma once
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/syntax/syntax.hpp"

namespace bip::parse {

struct TokenRow {
  std::size_t type = 0;  // of BipLexer, EOF excluded
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  std::uint32_t line = 1;
};

struct TokenList {
  std::vector<TokenRow> rows;
  std::vector<syntax::Comment> comments;
};

/// Lexes and classifies a file. Reports B0002-B0004. A file that is not UTF-8 has no tokens.
[[nodiscard]] TokenList read_tokens(const SourceMap& sources, FileId file, Diagnostics& diags);

/// The tokens of a piece of a text, not classified, with their places in the whole; `begin` is the piece's. Nothing if
/// there is something to report, or if the piece ends inside of a comment.
[[nodiscard]] std::optional<TokenList> read_sound_tokens(const SourceMap& sources, FileId file, std::uint32_t begin,
                                                         std::uint32_t end);

/// The tokens of a part of a text that begins between two words, not classified, with their places in the whole.
/// Reports as read_tokens(). Nothing, and no message, if what surrounds the part may matter.
[[nodiscard]] std::optional<TokenList> read_part(const SourceMap& sources, FileId file, std::uint32_t begin,
                                                 std::uint32_t end, Diagnostics& diags);

/// Classifies the tokens of a piece that begins and ends between two declarations. `ahead`: the types of the tokens
/// that follow it in the file, at most three; fewer if the file ends there. False if the piece ends elsewhere, or if a
/// token of it depends on more.
[[nodiscard]] bool classify_piece(std::vector<TokenRow>& rows, std::span<const std::size_t> ahead,
                                  std::string_view text);

/// Decides contextual words, reports, ranges and groups in place (see BipLexer.g4). Called by `read_tokens`.
void classify_tokens(std::vector<TokenRow>& rows, std::string_view text);

/// Reports B0008 and returns false if something is nested deeper than kMaxDepth: parentheses, blocks, `if`, `for`, runs
/// of unary operators. ANTLR recurses over all of these, so this must come first.
[[nodiscard]] bool check_depth(const std::vector<TokenRow>& rows, FileId file, Diagnostics& diags);

/// ID and the words that are names where the grammar has no use for them.
[[nodiscard]] bool is_name(std::size_t type);

/// Offset of the first byte that is not UTF-8, or npos.
[[nodiscard]] std::size_t find_bad_utf8(std::string_view text);

}  // namespace bip::parse
