// See document_text.hpp.
#include "tools/lsp/document_text.hpp"

#include <algorithm>

#include "compiler/source/utf8.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::lsp {
namespace {

/// Bytes of the first character, at least 1; and what it takes in the protocol's unit.
struct Step {
  std::uint32_t bytes;
  std::uint32_t units;
};
Step step(std::string_view text, Encoding encoding) {
  if (static_cast<unsigned char>(text.front()) < 0x80) return {1, 1};
  const auto bytes = static_cast<std::uint32_t>(std::max<std::size_t>(utf8_length(text), 1));
  return {bytes, encoding == Encoding::Utf8 ? bytes : bytes == 4 ? 2u : 1u};
}

}  // namespace

void Text::find_lines() {
  starts_.assign(1, 0);
  if (text_.find('\r') == std::string::npos) {
    // The usual case, in which the library's search is fast.
    for (std::size_t i = text_.find('\n'); i != std::string::npos; i = text_.find('\n', i + 1))
      starts_.push_back(static_cast<std::uint32_t>(i + 1));
    return;
  }
  for (std::size_t i = 0; i < text_.size(); ++i) {
    const bool is_lone_return = text_[i] == '\r' && (i + 1 == text_.size() || text_[i + 1] != '\n');
    if (text_[i] == '\n' || is_lone_return) starts_.push_back(static_cast<std::uint32_t>(i + 1));
  }
}

std::uint32_t Text::end_of_line(std::size_t line) const {
  BIP_ASSERT(line < starts_.size(), "line {} of {}", line, starts_.size());
  if (line + 1 == starts_.size()) return static_cast<std::uint32_t>(text_.size());
  std::uint32_t end = starts_[line + 1] - 1;
  if (text_[end] == '\n' && end > starts_[line] && text_[end - 1] == '\r') --end;
  return end;
}

std::optional<std::uint32_t> Text::offset(Position at, Encoding encoding) const {
  if (at.line >= starts_.size()) return std::nullopt;
  const std::uint32_t end = end_of_line(at.line);
  std::uint32_t offset = starts_[at.line];
  std::uint32_t column = 0;
  while (offset < end && column < at.character) {
    const Step s = step(std::string_view(text_).substr(offset, end - offset), encoding);
    if (column + s.units > at.character) break;
    column += s.units;
    offset += s.bytes;
  }
  BIP_ASSERT(offset <= end, "offset {} is behind the end {} of its line", offset, end);
  return offset;
}

std::uint32_t Text::clamped_offset(Position at, Encoding encoding) const {
  return offset(at, encoding).value_or(static_cast<std::uint32_t>(text_.size()));
}

Position Text::position(std::uint32_t offset, Encoding encoding) const {
  offset = std::min(offset, static_cast<std::uint32_t>(text_.size()));
  const auto line =
      static_cast<std::size_t>(std::upper_bound(starts_.begin(), starts_.end(), offset) - starts_.begin()) - 1;
  offset = std::min(offset, end_of_line(line));
  std::uint32_t column = 0;
  for (std::uint32_t at = starts_[line]; at < offset;) {
    const Step s = step(std::string_view(text_).substr(at), encoding);
    if (at + s.bytes > offset) break;
    column += s.units;
    at += s.bytes;
  }
  return {static_cast<std::uint32_t>(line), column};
}

void Text::replace(std::uint32_t begin, std::uint32_t end, std::string_view with) {
  BIP_ASSERT(begin <= end && end <= text_.size(), "bytes {} to {} of {} are replaced", begin, end, text_.size());
  text_.replace(begin, end - begin, with);
  find_lines();
}

}  // namespace bip::lsp
