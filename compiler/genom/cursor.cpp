// See cursor.hpp.
#include "compiler/genom/cursor.hpp"

#include <span>

#include "compiler/genom/condition.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {

std::string describe(const Token& token) {
  switch (token.kind) {
    case TokenKind::End: return "the end of the file";
    case TokenKind::String: return "a string";
    case TokenKind::Word:
    case TokenKind::Number:
    case TokenKind::Sign: break;
  }
  return fmt::format("`{}`", token.text);
}

DiagnosticBuilder Cursor::unexpected(std::string_view what) {
  return diags_->report(Diag::kB6000, peek().range, what, describe(peek()));
}

bool Cursor::expect(std::string_view text) {
  if (accept(text)) return true;
  // One report a token: what follows from it is not told again.
  if (last_report_ != at_) unexpected(fmt::format("`{}`", text));
  last_report_ = at_;
  return false;
}

bool Cursor::name(Name& into, std::string_view what) {
  if (peek().kind != TokenKind::Word) {
    if (last_report_ != at_) unexpected(what);
    last_report_ = at_;
    return false;
  }
  const Token& token = take();
  into = {std::string(token.text), token.range};
  return true;
}

bool Cursor::names(std::vector<Name>& into, std::string_view what) {
  do {
    Name next;
    if (!name(next, what)) return false;
    into.push_back(std::move(next));
  } while (accept(","));
  return true;
}

bool Cursor::number(std::int64_t& into, std::string_view ends, std::int64_t low, std::int64_t high,
                    std::string_view what) {
  const std::size_t begin = at_;
  const auto is_end = [&](const Token& t) {
    return t.kind == TokenKind::End ||
           (t.kind == TokenKind::Sign && t.text.size() == 1 && ends.find(t.text) != std::string_view::npos);
  };
  while (!is_end(peek())) take();
  BIP_ASSERT(begin <= at_ && at_ < tokens_->size(), "token {} of {}", at_, tokens_->size());
  const std::span<const Token> tokens(tokens_->data() + begin, at_ - begin);
  const std::optional<std::int64_t> value = constant_value(tokens);
  SourceRange range = tokens.empty() ? peek().range : tokens.front().range;
  if (!tokens.empty() && tokens.back().range.file == range.file) range.end = tokens.back().range.end;
  if (!value) {
    diags_->report(Diag::kB6000, range, fmt::format("a whole number for {}", what),
                   tokens.empty() ? describe(peek()) : describe(tokens.front()));
    return false;
  }
  into = *value;
  if (*value >= low && *value <= high) return true;
  diags_->report(Diag::kB6010, range, what, *value, low, high);
  return false;
}

void Cursor::skip_past_semicolon() {
  std::size_t depth = 0;
  while (!at_end()) {
    if (depth == 0 && at("}")) return;
    const Token& token = take();
    if (token.is("{")) ++depth;
    if (token.is("}")) --depth;
    if (depth == 0 && token.is(";")) return;
  }
}

bool Cursor::skip_group() {
  BIP_ASSERT(!at_end(), "a group at the end");
  std::vector<std::string_view> closers;
  const SourceRange start = peek().range;
  do {
    const Token& token = take();
    if (token.kind == TokenKind::Sign) {
      if (token.text == "{") closers.push_back("}");
      if (token.text == "(") closers.push_back(")");
      if (token.text == "[") closers.push_back("]");
      if (!closers.empty() && token.text == closers.back()) closers.pop_back();
    }
  } while (!closers.empty() && !at_end());
  if (!closers.empty()) diags_->report(Diag::kB6002, start, "block", std::string(closers.front()));
  return closers.empty();
}

}  // namespace bip::genom
