// A document's text and the positions of the protocol: lines from 0, columns in UTF-16 units or, if both sides agree,
// bytes.
//
// Lines end with \n, \r\n or \r, as the protocol has it. A column past the end of its line means its end, one inside a
// character its begin. Cost: a binary search for the line, then linear in the line; an edit is linear in the text.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bip::lsp {

enum class Encoding : std::uint8_t { Utf16, Utf8 };

struct Position {
  std::uint32_t line = 0;
  std::uint32_t character = 0;
};

class Text {
 public:
  explicit Text(std::string text) : text_(std::move(text)) { find_lines(); }

  [[nodiscard]] const std::string& str() const { return text_; }
  [[nodiscard]] std::size_t line_count() const { return starts_.size(); }
  /// nullopt: there is no such line.
  [[nodiscard]] std::optional<std::uint32_t> offset(Position at, Encoding encoding) const;
  /// As `offset`, but a line past the end is the end.
  [[nodiscard]] std::uint32_t clamped_offset(Position at, Encoding encoding) const;
  [[nodiscard]] Position position(std::uint32_t offset, Encoding encoding) const;
  void replace(std::uint32_t begin, std::uint32_t end, std::string_view with);

 private:
  void find_lines();
  [[nodiscard]] std::uint32_t end_of_line(std::size_t line) const;

  std::string text_;
  std::vector<std::uint32_t> starts_;
};

}  // namespace bip::lsp
