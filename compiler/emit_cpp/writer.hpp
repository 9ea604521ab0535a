// The text of the emitted file with its #line bookkeeping, and the spelling of names and constants in C++.
//
// `at(loc)` writes a #line only if the compiler would otherwise assume another line, so most of the code has none.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/source/source.hpp"

namespace bip::emit_cpp {

class CppWriter {
 public:
  CppWriter(const std::vector<std::string>& files, bool line_directives)
      : files_(files), line_directives_(line_directives) {}

  void line(std::string_view text = {}) {
    text_ += text;
    text_ += '\n';
  }
  /// The next line belongs to `loc`.
  void at(const Loc& loc);
  /// "file:line" as people write it; empty if there is no place.
  [[nodiscard]] std::string place(const Loc& loc) const;
  [[nodiscard]] bool has_line_directives() const { return line_directives_; }
  /// The next line belongs to the emitted file itself.
  void at_emitted();
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  const std::vector<std::string>& files_;
  bool line_directives_;
  std::string text_;
  bool in_model_ = false;   // a #line to a .bip is in force
  std::uint32_t file_ = 0;  // its file
  std::uint32_t line_ = 0;  // the line of the text at mark_
  std::size_t mark_ = 0;
};

/// "text" with quotes, escaped; bytes that are not printable ASCII as octal.
[[nodiscard]] std::string string_literal(std::string_view text);
/// The shortest decimal that reads back as `value`.
[[nodiscard]] std::string float_literal(double value);
[[nodiscard]] std::string int_literal(std::int32_t value);
/// `text` as it may stand in a // or /* */ comment.
[[nodiscard]] std::string comment_text(std::string_view text);
/// Keywords, macros and helpers that a variable of the model shall not be called.
[[nodiscard]] const std::vector<std::string_view>& reserved_words();

}  // namespace bip::emit_cpp
