// See index_expression.hpp. By recursive descent.
#include "compiler/system/index_expression.hpp"

#include "compiler/base/ascii.hpp"

namespace bip::system {

namespace {

// Deeper ones have no value.
constexpr int kMostParentheses = 100;
constexpr std::int64_t kGreatest = 0x7fffffff;

class IndexEvaluator {
 public:
  IndexEvaluator(std::string_view text, std::size_t at, const ValueOfName& value_of)
      : text_(text), at_(at), value_of_(value_of) {}

  std::optional<std::int64_t> sum(int depth) {
    std::optional<std::int64_t> left = product(depth);
    for (skip_blanks(); left && (peek() == '+' || peek() == '-'); skip_blanks()) {
      const bool adds = text_[at_++] == '+';
      const std::optional<std::int64_t> right = product(depth);
      left = right ? limited(adds ? *left + *right : *left - *right) : std::nullopt;
    }
    return left;
  }
  [[nodiscard]] std::size_t at() const { return at_; }

 private:
  [[nodiscard]] char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void skip_blanks() {
    while (peek() == ' ' || peek() == '\t' || peek() == '\r' || peek() == '\n') ++at_;
  }
  static std::optional<std::int64_t> limited(std::int64_t value) {
    return value < -kGreatest || value > kGreatest ? std::nullopt : std::optional(value);
  }
  std::optional<std::int64_t> product(int depth) {
    std::optional<std::int64_t> left = factor(depth);
    for (skip_blanks(); left && (peek() == '*' || peek() == '/' || peek() == '%'); skip_blanks()) {
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
    if (peek() == '-') {
      ++at_;
      const std::optional<std::int64_t> value = factor(depth + 1);
      return value ? std::optional(-*value) : std::nullopt;
    }
    if (peek() == '(') {
      ++at_;
      const std::optional<std::int64_t> value = sum(depth + 1);
      skip_blanks();
      if (peek() != ')') return std::nullopt;
      ++at_;
      return value;
    }
    if (is_digit(peek())) {
      std::int64_t value = 0;
      for (; is_digit(peek()) && value <= kGreatest; ++at_) value = value * 10 + (text_[at_] - '0');
      return limited(value);
    }
    const std::size_t first = at_;
    while (is_letter(peek()) || peek() == '_' || (at_ > first && is_digit(peek()))) ++at_;
    return at_ == first ? std::nullopt : value_of_(text_.substr(first, at_ - first));
  }

  std::string_view text_;
  std::size_t at_;
  const ValueOfName& value_of_;
};

}  // namespace

std::optional<std::int64_t> evaluate_index(std::string_view text, std::size_t& at, const ValueOfName& value_of) {
  IndexEvaluator evaluator(text, at, value_of);
  const std::optional<std::int64_t> value = evaluator.sum(0);
  at = evaluator.at();
  return value;
}

}  // namespace bip::system
