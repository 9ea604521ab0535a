// One pass over the bytes. A backslash before a line break joins lines, as C has it.
#include <cctype>

#include "compiler/genom/tokens.hpp"
#include "compiler/base/ascii.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

class Lexer {
 public:
  Lexer(const SourceMap& sources, FileId file, Diagnostics& diags)
      : text_(sources.text(file)), file_(file), diags_(diags) {}

  std::vector<Token> run() {
    while (skip_blanks()) token();
    add(TokenKind::End, at_, at_);
    return std::move(tokens_);
  }

 private:
  [[nodiscard]] char peek(std::size_t ahead = 0) const {
    return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0';
  }
  [[nodiscard]] SourceRange range(std::size_t begin, std::size_t end) const {
    return {file_, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end)};
  }

  void add(TokenKind kind, std::size_t begin, std::size_t end, std::size_t cut = 0) {
    BIP_ASSERT(begin + 2 * cut <= end && end <= text_.size(), "token {}..{} of {} bytes", begin, end, text_.size());
    BIP_ASSERT(tokens_.empty() || tokens_.back().range.end <= begin, "token at {} overlaps the one before", begin);
    tokens_.push_back({kind, new_line_, text_.substr(begin + cut, end - begin - 2 * cut), range(begin, end)});
    new_line_ = false;
  }

  // False at the end of the text.
  bool skip_blanks() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '\n') {
        new_line_ = true;
        ++at_;
      } else if (c == '\\' && (peek(1) == '\n' || (peek(1) == '\r' && peek(2) == '\n'))) {
        at_ += peek(1) == '\n' ? 2 : 3;
      } else if (c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v') {
        ++at_;
      } else if (c == '/' && peek(1) == '/') {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
      } else if (c == '/' && peek(1) == '*') {
        skip_comment();
      } else {
        return true;
      }
    }
    return false;
  }

  void skip_comment() {
    const std::size_t end = text_.find("*/", at_ + 2);
    if (end == std::string_view::npos) diags_.report(Diag::kB6002, range(at_, at_ + 2), "comment", "*/");
    at_ = end == std::string_view::npos ? text_.size() : end + 2;
  }

  void token() {
    const std::size_t begin = at_;
    BIP_ASSERT(at_ < text_.size(), "a token at the end");
    const char c = peek();
    if (is_digit(c) || (c == '.' && is_digit(peek(1)))) {
      number();
      add(TokenKind::Number, begin, at_);
    } else if (is_word(c)) {
      while (is_word(peek())) ++at_;
      add(TokenKind::Word, begin, at_);
    } else if (c == '"' || c == '\'') {
      quoted(begin, c);
    } else if (static_cast<unsigned char>(c) >= 0x80 || std::iscntrl(static_cast<unsigned char>(c)) != 0) {
      // One report for a run of them.
      while (at_ < text_.size() && (static_cast<unsigned char>(peek()) >= 0x80 ||
                                    (std::iscntrl(static_cast<unsigned char>(peek())) != 0 && peek() != '\n')))
        ++at_;
      diags_.report(Diag::kB6003, range(begin, at_), text_.substr(begin, at_ - begin))
          .help("outside of comments and strings a description is plain ASCII");
    } else {
      static constexpr std::string_view kPairs[] = {"::", "&&", "||", "==", "!=", "<=", ">="};
      std::size_t length = 1;
      for (const std::string_view pair : kPairs) {
        if (text_.substr(at_, 2) == pair) length = 2;
      }
      at_ += length;
      add(TokenKind::Sign, begin, at_);
    }
  }

  // 12, 0x1f, 1.5, 1e-3, 10u.
  void number() {
    const bool is_hex = peek() == '0' && (peek(1) == 'x' || peek(1) == 'X');
    while (is_word(peek()) || peek() == '.') {
      const bool is_exponent = !is_hex && (peek() == 'e' || peek() == 'E');
      ++at_;
      if (is_exponent && (peek() == '+' || peek() == '-')) ++at_;
    }
  }

  void quoted(std::size_t begin, char quote) {
    ++at_;
    while (at_ < text_.size() && peek() != quote && peek() != '\n')
      at_ += peek() == '\\' && at_ + 1 < text_.size() ? 2 : 1;
    if (peek() != quote) {
      diags_.report(Diag::kB6002, range(begin, begin + 1), "string", std::string(1, quote));
      return;
    }
    ++at_;
    add(TokenKind::String, begin, at_, 1);
  }

  std::string_view text_;
  FileId file_;
  Diagnostics& diags_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  bool new_line_ = true;
};

}  // namespace

std::vector<Token> lex(const SourceMap& sources, FileId file, Diagnostics& diags) {
  return Lexer(sources, file, diags).run();
}

bool whole_number(std::string_view text, std::int64_t& value) {
  const bool is_hex = text.size() > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
  if (is_hex) text.remove_prefix(2);
  while (!text.empty() && (text.back() == 'u' || text.back() == 'U' || text.back() == 'l' || text.back() == 'L'))
    text.remove_suffix(1);
  if (text.empty()) return false;
  value = 0;
  const std::int64_t base = is_hex ? 16 : 10;
  for (const char c : text) {
    std::int64_t digit = 0;
    if (is_digit(c)) {
      digit = c - '0';
    } else if (is_hex && std::isxdigit(static_cast<unsigned char>(c)) != 0) {
      digit = std::tolower(static_cast<unsigned char>(c)) - 'a' + 10;
    } else {
      return false;
    }
    if (value > ((std::int64_t{1} << 62) - digit) / base) return false;
    value = value * base + digit;
  }
  return true;
}

}  // namespace bip::genom
