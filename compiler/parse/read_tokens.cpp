// Lexes a file with ANTLR's lexer, converts positions from code points to bytes, separates comments, and reports
// lexical errors. The lexer cannot fail: its last rules match any remaining character.
#include <algorithm>
#include <string>

#include "BipLexer.h"
#include "antlr4-runtime.h"
#include "compiler/parse/each_token.hpp"
#include "compiler/parse/token_list.hpp"
#include "compiler/source/utf8.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {
namespace {

using antlr::BipLexer;

void report_stray(std::string_view sign, std::string_view after, SourceRange range, Diagnostics& diags) {
  const auto code = static_cast<unsigned char>(sign.empty() ? '\0' : sign.front());
  if (code < 0x20 || code == 0x7F) {
    diags.report(Diag::kB0002, range, fmt::format("\\x{:02x}", code)).label("a control character");
    return;
  }
  auto diagnostic = diags.report(Diag::kB0002, range, sign);
  if (sign == "#" && after.starts_with("include"))
    diagnostic.note("files are no part of a text: packages are used by `use NAME`, first in the package");
  else if (sign == "#") diagnostic.help("comments begin with `//`", range, "//");
  if (sign == "?")
    diagnostic.note("ports have no direction, and there is no `a ? b : c`: an `if` of an action chooses");
  if (sign == "$") diagnostic.help("names consist of letters, digits and `_`");
}

/// Adds a token to the list, or reports it.
void add_token(const TokenRow& row, const SourceMap& sources, FileId file, TokenList& list, Diagnostics& diags) {
  BIP_ASSERT(list.rows.empty() || list.rows.back().end <= row.begin, "token at {} overlaps the one before", row.begin);
  const SourceRange range{file, row.begin, row.end};
  switch (row.type) {
    case BipLexer::LINE_COMMENT:
    case BipLexer::BLOCK_COMMENT: list.comments.push_back({range}); break;
    case BipLexer::UNCLOSED_COMMENT:
      diags.report(Diag::kB0003, SourceRange{file, row.begin, row.begin + 2})
          .label("opened here, open to the end of the file");
      break;
    case BipLexer::UNCLOSED_STRING:
      diags.report(Diag::kB0004, range)
          .label("the line ends inside the string")
          .help("a line break in a string is written `\\n`");
      list.rows.push_back(row);
      list.rows.back().type = BipLexer::STRING;
      break;
    case BipLexer::STRAY: report_stray(sources.text(range), sources.text(file).substr(row.end), range, diags); break;
    default: list.rows.push_back(row);
  }
}

// Once for each line that has such a character, so that a text written from right to left gives few warnings.
void warn_of_bidi_controls(std::string_view text, FileId file, Diagnostics& diags) {
  std::size_t next = 0;
  // All of them begin with one of these bytes.
  for (std::size_t at = text.find_first_of("\xD8\xE2"); at != std::string_view::npos;
       at = text.find_first_of("\xD8\xE2", at + 1)) {
    if (at < next || !is_bidi_control(text.substr(at))) continue;
    const std::size_t length = utf8_length(text.substr(at));
    const std::string_view bytes = text.substr(at, length);
    std::uint32_t code = static_cast<unsigned char>(bytes[0]) & (length == 2 ? 0x1Fu : 0x0Fu);
    for (const char byte : bytes.substr(1)) code = (code << 6u) | (static_cast<unsigned char>(byte) & 0x3Fu);
    diags.report(Diag::kB0022,
                 SourceRange{file, static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(at + length)},
                 fmt::format("{:04X}", code));
    next = std::min(text.find('\n', at), text.size());
  }
}

}  // namespace

bool is_name(std::size_t type) {
  switch (type) {
    case BipLexer::ID:
    case BipLexer::CLOCK:
    case BipLexer::UNIT:
    case BipLexer::INVARIANT:
    case BipLexer::AT:
    case BipLexer::FINAL:
    case BipLexer::LAZY:
    case BipLexer::DELAYABLE:
    case BipLexer::EAGER:
    case BipLexer::RESUME:
    case BipLexer::REMEMBER:
    case BipLexer::IGNORE:
    case BipLexer::ERROR:
    case BipLexer::AND_WORD:
    case BipLexer::OR_WORD: return true;
    default: return false;
  }
}

std::size_t find_bad_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    std::size_t length = lead < 0x80               ? 1
                         : (lead & 0xE0u) == 0xC0u ? 2
                         : (lead & 0xF0u) == 0xE0u ? 3
                         : (lead & 0xF8u) == 0xF0u ? 4
                                                   : 0;
    if (length == 0 || i + length > text.size()) return i;
    std::uint32_t code = length == 1 ? lead : lead & (0xFFu >> (length + 1));
    for (std::size_t k = 1; k < length; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      if ((next & 0xC0u) != 0x80u) return i;
      code = (code << 6u) | (next & 0x3Fu);
    }
    const bool overlong =
        (length == 2 && code < 0x80) || (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
    if (overlong || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return i;
    i += length;
  }
  return std::string_view::npos;
}

TokenList read_tokens(const SourceMap& sources, FileId file, Diagnostics& diags) {
  TokenList list;
  std::string_view text = sources.text(file);
  if (const std::size_t bad = find_bad_utf8(text); bad != std::string_view::npos) {
    const auto at = static_cast<std::uint32_t>(bad);
    diags
        .report(Diag::kB0002, SourceRange{file, at, at + 1},
                fmt::format("\\x{:02x}", static_cast<unsigned char>(text[bad])))
        .label("not UTF-8");
    return list;
  }
  warn_of_bidi_controls(text, file, diags);
  // ANTLR would swallow a byte order mark and count positions from after it.
  const std::uint32_t skipped = text.substr(0, 3) == "\xEF\xBB\xBF" ? 3 : 0;
  each_token<BipLexer>(text.substr(skipped), skipped,
                       [&](const TokenRow& row) { add_token(row, sources, file, list, diags); });
  classify_tokens(list.rows, sources.text(file));
  return list;
}

std::optional<TokenList> read_part(const SourceMap& sources, FileId file, std::uint32_t begin, std::uint32_t end,
                                   Diagnostics& diags) {
  const std::string_view text = sources.text(SourceRange{file, begin, end});
  if (find_bad_utf8(text) != std::string_view::npos || text.starts_with("\xEF\xBB\xBF")) return std::nullopt;
  Diagnostics remarks;
  warn_of_bidi_controls(text, file, remarks);
  if (remarks.warning_count() != 0) return std::nullopt;
  const std::uint32_t lines = sources.loc(file, begin).line - 1;
  TokenList list;
  bool is_closed = true;
  each_token<BipLexer>(text, begin, [&](TokenRow row) {
    row.line += lines;
    is_closed = is_closed && row.type != BipLexer::UNCLOSED_COMMENT;
    if (is_closed) add_token(row, sources, file, list, diags);
  });
  return is_closed ? std::optional(std::move(list)) : std::nullopt;
}

std::optional<TokenList> read_sound_tokens(const SourceMap& sources, FileId file, std::uint32_t begin,
                                           std::uint32_t end) {
  const std::string_view text = sources.text(SourceRange{file, begin, end});
  if (find_bad_utf8(text) != std::string_view::npos || text.starts_with("\xEF\xBB\xBF")) return std::nullopt;
  Diagnostics remarks;
  warn_of_bidi_controls(text, file, remarks);
  if (remarks.warning_count() != 0) return std::nullopt;
  TokenList list;
  bool is_sound = true;
  each_token<BipLexer>(text, begin, [&](const TokenRow& row) {
    switch (row.type) {
      case BipLexer::LINE_COMMENT:
      case BipLexer::BLOCK_COMMENT: list.comments.push_back({SourceRange{file, row.begin, row.end}}); break;
      case BipLexer::UNCLOSED_COMMENT:
      case BipLexer::UNCLOSED_STRING:
      case BipLexer::STRAY: is_sound = false; break;
      default: list.rows.push_back(row);
    }
  });
  return is_sound ? std::optional(std::move(list)) : std::nullopt;
}

}  // namespace bip::parse
