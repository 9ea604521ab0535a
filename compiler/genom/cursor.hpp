// The position of a parser in its tokens, and operations of both parsers: look, expect, name, skip.
//
// A parse function that returns false has reported the error; its caller recovers with `skip_past`. There is no
// backtracking.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/genom/module.hpp"
#include "compiler/genom/tokens.hpp"

namespace bip::genom {

class Cursor {
 public:
  Cursor(const std::vector<Token>& tokens, Diagnostics& diags) : tokens_(&tokens), diags_(&diags) {}

  [[nodiscard]] const Token& peek(std::size_t ahead = 0) const {
    return at_ + ahead < tokens_->size() ? (*tokens_)[at_ + ahead] : tokens_->back();
  }
  [[nodiscard]] bool at(std::string_view text) const { return peek().is(text); }
  [[nodiscard]] bool at_end() const { return peek().kind == TokenKind::End; }
  /// The current token, and on.
  const Token& take() {
    const Token& token = peek();
    if (!at_end()) ++at_;
    return token;
  }
  bool accept(std::string_view text) {
    if (!at(text)) return false;
    take();
    return true;
  }
  [[nodiscard]] Diagnostics& diags() { return *diags_; }

  /// Reports B6000 at the current token: "expected {what}, found …".
  DiagnosticBuilder unexpected(std::string_view what);
  bool expect(std::string_view text);
  /// A name; nothing is reported twice at one token.
  bool name(Name& into, std::string_view what);
  /// name { ',' name }
  bool names(std::vector<Name>& into, std::string_view what);
  /// A constant expression up to one of the signs in `ends`, in range; `what` names it in messages.
  bool number(std::int64_t& into, std::string_view ends, std::int64_t low, std::int64_t high, std::string_view what);

  /// Skips until after the next `;` at this depth of braces, or to a `}` that closes the surrounding block.
  void skip_past_semicolon();
  /// After the matching closer of the brace, parenthesis or bracket that is next.
  bool skip_group();
  [[nodiscard]] std::size_t position() const { return at_; }

 private:
  const std::vector<Token>* tokens_;
  Diagnostics* diags_;
  std::size_t at_ = 0;
  std::size_t last_report_ = static_cast<std::size_t>(-1);
};

/// "`;`", "`speed`", "a string", "the end of the file".
[[nodiscard]] std::string describe(const Token& token);

}  // namespace bip::genom
