// See expand_property.hpp. One pass over the text; what it does not know it copies.
#include "compiler/system/expand_property.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "compiler/base/ascii.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::system {

namespace {

// Of an index; deeper ones have no value.
constexpr int kMostParentheses = 100;
constexpr std::int64_t kGreatest = 0x7fffffff;

bool begins_name(char c) { return is_letter(c) || c == '_'; }

class PropertyExpander {
 public:
  PropertyExpander(std::string_view text, const std::string& scope,
                   const std::map<std::string, Value, std::less<>>& constants, const std::vector<std::string>& strings)
      : text_(text), scope_(scope), constants_(constants), strings_(strings) {}

  Result<ExpandedProperty> run() {
    while (at_ < text_.size() && problem_.empty()) expand_token();
    if (!problem_.empty()) return Failure{problem_};
    while (!out_.text.empty() && out_.text.back() == ' ') {
      out_.text.pop_back();
      out_.source.pop_back();
    }
    out_.source.push_back(static_cast<std::uint32_t>(std::min(text_.find_last_not_of(" \t\r\n") + 1, text_.size())));
    BIP_ASSERT(out_.source.size() == out_.text.size() + 1, "{} places of {} bytes", out_.source.size(),
               out_.text.size());
    return std::move(out_);
  }

 private:
  void put(std::string_view what, std::size_t from) {
    out_.text.append(what);
    out_.source.insert(out_.source.end(), what.size(), static_cast<std::uint32_t>(from));
  }
  void copy_until(std::size_t end) {
    for (; at_ < end; ++at_) put(text_.substr(at_, 1), at_);
  }
  [[nodiscard]] char peek(std::size_t at) const { return at < text_.size() ? text_[at] : '\0'; }
  [[nodiscard]] static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  void expand_token() {
    const char c = text_[at_];
    const std::string_view two = text_.substr(at_, 2);
    if (is_blank(c)) {
      put_blank();
      ++at_;
    } else if (two == "//" || two == "/*") {
      put_blank();
      const std::size_t end = text_.find(two == "//" ? "\n" : "*/", at_ + 2);
      at_ = end == std::string_view::npos ? text_.size() : end + (two == "//" ? 1 : 2);
    } else if (c == '"') {
      const std::size_t end = text_.find('"', at_ + 1);
      copy_until(end == std::string_view::npos ? text_.size() : end + 1);
      last_word_ = {};
    } else if (is_digit(c)) {
      std::size_t end = at_;
      while (end < text_.size() && (is_digit(text_[end]) || begins_name(text_[end]) || text_[end] == '.')) ++end;
      copy_until(end);
      is_unit_ = last_word_ == "within";
      last_word_ = {};
    } else if (begins_name(c)) {
      expand_name();
    } else {
      is_place_ = c == '@';
      is_unit_ = false;
      last_word_ = {};
      copy_until(at_ + 1);
    }
  }
  void put_blank() {
    if (!out_.text.empty() && out_.text.back() != ' ') put(" ", at_);
  }
  [[nodiscard]] std::string_view word_at(std::size_t at) const {
    std::size_t end = at;
    while (end < text_.size() && (begins_name(text_[end]) || is_digit(text_[end]))) ++end;
    return text_.substr(at, end - at);
  }

  void expand_name() {
    const std::string_view word = word_at(at_);
    if (is_place_) {
      is_place_ = false;
      return copy_until(at_ + word.size());
    }
    if (std::exchange(is_unit_, false)) return copy_until(at_ + word.size());
    std::size_t behind = at_ + word.size();
    const bool is_path = peek(behind) == '[' || (peek(behind) == '.' && begins_name(peek(behind + 1)));
    while (is_blank(peek(behind))) ++behind;
    const bool is_component = peek(behind) == '@';
    const bool is_offer = last_word_ == "can" || last_word_ == "happens";
    is_unit_ = last_word_ == "within";
    last_word_ = word;
    if (is_path || is_component || is_offer) return expand_path(word);
    if (const auto constant = constants_.find(word); constant != constants_.end()) {
      put(value_text(constant->second), at_);
      at_ += word.size();
      return;
    }
    copy_until(at_ + word.size());
  }
  void expand_path(std::string_view word) {
    if (word != "ROOT") put(scope_, at_);
    for (;;) {
      copy_until(at_ + word_at(at_).size());
      while (peek(at_) == '[' && problem_.empty()) expand_index();
      if (peek(at_) != '.' || !begins_name(peek(at_ + 1)) || !problem_.empty()) return;
      copy_until(at_ + 1);
    }
  }
  void expand_index() {
    const std::size_t open = at_++;
    const std::optional<std::int64_t> index = sum(0);
    skip_blanks();
    if (!index || peek(at_) != ']') {
      const std::size_t close = std::min(text_.find(']', open), text_.size() - 1);
      problem_ = fmt::format("the index `{}` is no number: it may name parameters and variables of loops",
                             text_.substr(open, close - open + 1));
    } else if (*index < 0) {
      problem_ = fmt::format("an index is at least 0, this is {}", *index);
    } else {
      put(fmt::format("[{}]", *index), open);
      ++at_;
    }
  }

  // ---- values of indices: C's `+ - * / %` of numbers and constants
  void skip_blanks() {
    while (is_blank(peek(at_))) ++at_;
  }
  static std::optional<std::int64_t> limited(std::int64_t value) {
    return value < -kGreatest || value > kGreatest ? std::nullopt : std::optional(value);
  }
  std::optional<std::int64_t> sum(int depth) {
    std::optional<std::int64_t> left = product(depth);
    for (skip_blanks(); left && (peek(at_) == '+' || peek(at_) == '-'); skip_blanks()) {
      const bool adds = text_[at_++] == '+';
      const std::optional<std::int64_t> right = product(depth);
      left = right ? limited(adds ? *left + *right : *left - *right) : std::nullopt;
    }
    return left;
  }
  std::optional<std::int64_t> product(int depth) {
    std::optional<std::int64_t> left = factor(depth);
    for (skip_blanks(); left && (peek(at_) == '*' || peek(at_) == '/' || peek(at_) == '%'); skip_blanks()) {
      const char sign = text_[at_++];
      const std::optional<std::int64_t> right = factor(depth);
      if (!right || (sign != '*' && *right == 0)) return std::nullopt;
      left = limited(sign == '*' ? *left * *right : sign == '/' ? *left / *right : *left % *right);
    }
    return left;
  }
  std::optional<std::int64_t> factor(int depth) {
    skip_blanks();
    if (depth > kMostParentheses) return std::nullopt;
    if (peek(at_) == '-') {
      ++at_;
      const std::optional<std::int64_t> value = factor(depth + 1);
      return value ? std::optional(-*value) : std::nullopt;
    }
    if (peek(at_) == '(') {
      ++at_;
      const std::optional<std::int64_t> value = sum(depth + 1);
      skip_blanks();
      return peek(at_++) == ')' ? value : std::nullopt;
    }
    if (is_digit(peek(at_))) {
      std::int64_t value = 0;
      for (; is_digit(peek(at_)) && value <= kGreatest; ++at_) value = value * 10 + (text_[at_] - '0');
      return limited(value);
    }
    const std::string_view word = word_at(at_);
    const auto constant = constants_.find(word);
    if (word.empty() || constant == constants_.end() || constant->second.type != Type::Int) return std::nullopt;
    at_ += word.size();
    return constant->second.int_value;
  }

  [[nodiscard]] std::string value_text(const Value& value) const {
    if (value.type == Type::Bool) return value.int_value != 0 ? "true" : "false";
    if (value.type == Type::String) return '"' + strings_[static_cast<std::size_t>(value.int_value)] + '"';
    std::string digits =
        value.type == Type::Float ? fmt::format("{}", value.float_value) : fmt::format("{}", value.int_value);
    // A whole number stays a `float`.
    if (value.type == Type::Float && digits.find_first_of(".en") == std::string::npos) digits += ".0";
    return digits.front() == '-' ? "(" + digits + ")" : digits;
  }

  std::string_view text_;
  const std::string& scope_;
  const std::map<std::string, Value, std::less<>>& constants_;
  const std::vector<std::string>& strings_;
  ExpandedProperty out_;
  std::string problem_;
  std::string_view last_word_;  // of the tokens before this one, if it is a name
  bool is_place_ = false;       // behind `@`
  bool is_unit_ = false;        // behind the number of `within 50 ms`: no name of a parameter
  std::size_t at_ = 0;
};

}  // namespace

Result<ExpandedProperty> expand_property(std::string_view text, const std::string& scope,
                                         const std::map<std::string, Value, std::less<>>& constants,
                                         const std::vector<std::string>& strings) {
  return PropertyExpander(text, scope, constants, strings).run();
}

}  // namespace bip::system
