// See writer.hpp.
#include "compiler/emit_cpp/writer.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace bip::emit_cpp {

void CppWriter::at(const Loc& loc) {
  if (!line_directives_ || loc.line == 0 || loc.file >= files_.size()) return;
  const auto lines = std::count(text_.begin() + static_cast<std::ptrdiff_t>(mark_), text_.end(), '\n');
  const bool same_file = in_model_ && file_ == loc.file;
  const bool same_line = same_file && line_ + static_cast<std::uint32_t>(lines) == loc.line;
  if (!same_line) {
    text_ += "#line " + std::to_string(loc.line);
    if (!same_file) text_ += " " + string_literal(files_[loc.file]);
    text_ += '\n';
  }
  in_model_ = true;
  file_ = loc.file;
  line_ = loc.line;
  mark_ = text_.size();
}

void CppWriter::at_emitted() {
  if (!in_model_) return;
  in_model_ = false;
  const auto lines = std::count(text_.begin(), text_.end(), '\n');
  text_ += "#line " + std::to_string(lines + 2) + " \"model.cpp\"\n";
}

std::string CppWriter::place(const Loc& loc) const {
  if (loc.line == 0 || loc.file >= files_.size()) return {};
  return comment_text(files_[loc.file]) + ":" + std::to_string(loc.line);
}

std::string string_literal(std::string_view text) {
  std::string out = "\"";
  char previous = 0;
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '?' && previous == '?') {
      // No trigraphs, whatever the compiler's mode.
      out += "\\?";
    } else if (c >= 0x20 && c < 0x7f) {
      out += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      out += '\\';
      for (const int shift : {6, 3, 0}) out += static_cast<char>('0' + ((byte >> shift) & 7));
    }
    previous = c;
  }
  return out + '"';
}

std::string float_literal(double value) {
  if (std::isnan(value)) return "std::numeric_limits<double>::quiet_NaN()";
  if (std::isinf(value)) return std::string(value < 0 ? "-" : "") + "std::numeric_limits<double>::infinity()";
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  std::string text(buffer, end);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string int_literal(std::int32_t value) { return value == INT32_MIN ? "INT32_MIN" : std::to_string(value); }

std::string comment_text(std::string_view text) {
  constexpr std::size_t kMaxText = 120;
  std::string out;
  for (const char c : text.substr(0, kMaxText)) {
    const bool plain = c >= 0x20 && c < 0x7f && c != '\\' && c != '?';
    const bool ends_comment = c == '/' && !out.empty() && out.back() == '*';
    const bool opens_comment = c == '*' && !out.empty() && out.back() == '/';
    out += plain && !ends_comment && !opens_comment ? c : '.';
  }
  if (text.size() > kMaxText) out += "...";
  return out;
}

const std::vector<std::string_view>& reserved_words() {
  static const std::vector<std::string_view> kWords = {
      // C++20, with the spelled operators
      "alignas", "alignof", "and", "and_eq", "asm", "auto", "bitand", "bitor", "bool", "break", "case", "catch", "char",
      "char16_t", "char32_t", "char8_t", "class", "co_await", "co_return", "co_yield", "compl", "concept", "const",
      "const_cast", "consteval", "constexpr", "constinit", "continue", "decltype", "default", "delete", "do", "double",
      "dynamic_cast", "else", "enum", "explicit", "export", "extern", "false", "float", "for", "friend", "goto", "if",
      "inline", "int", "long", "mutable", "namespace", "new", "noexcept", "not", "not_eq", "nullptr", "operator", "or",
      "or_eq", "private", "protected", "public", "register", "reinterpret_cast", "requires", "return", "short",
      "signed", "sizeof", "static", "static_assert", "static_cast", "struct", "switch", "template", "this",
      "thread_local", "throw", "true", "try", "typedef", "typeid", "typename", "union", "unsigned", "using", "virtual",
      "void", "volatile", "wchar_t", "while", "xor", "xor_eq",
      // macros that are not in capitals
      "assert", "errno", "linux", "stderr", "stdin", "stdout", "unix",
      // what emitted functions call
      "all", "bind", "self", "Cell", "IntVar", "BoolVar", "FloatVar", "StringVar", "ColumnCell", "IntCell", "BoolCell",
      "StringCell", "CodeFault", "FfiVariable", "ffi"};
  return kWords;
}

}  // namespace bip::emit_cpp
