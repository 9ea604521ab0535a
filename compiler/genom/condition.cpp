// See condition.hpp. Arithmetic wraps, because overflow in a description is meaningless.
#include "compiler/genom/condition.hpp"

#include <string_view>

#include "compiler/genom/operators.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

constexpr int kMaxConditionDepth = 100;

std::int64_t wrap(std::uint64_t value) { return static_cast<std::int64_t>(value); }

class Evaluator {
 public:
  explicit Evaluator(std::span<const Token> tokens) : tokens_(tokens) {}

  std::optional<std::int64_t> run() {
    const std::int64_t value = climb_operators(*this);
    BIP_ASSERT(depth_ == 0, "{} operands are open at word {}", depth_, at_);
    if (failed_ || at_ != tokens_.size()) return std::nullopt;
    return value;
  }

  // ---- of climb_operators

  std::int64_t operand() {
    if (depth_ > kMaxConditionDepth || at_ >= tokens_.size()) {
      failed_ = true;
      return 0;
    }
    ++depth_;
    const std::int64_t value = unary(tokens_[at_++]);
    --depth_;
    return value;
  }

  [[nodiscard]] BinaryOperator next_operator() const {
    if (failed_ || at_ >= tokens_.size()) return {};
    return binary_operator_at(tokens_[at_], at_ + 1 < tokens_.size() ? tokens_[at_ + 1] : Token{});
  }

  std::size_t take(const BinaryOperator& op) { return at_ += op.is_shift() ? 2 : 1; }

  std::int64_t apply(const BinaryOperator& binary, std::size_t, std::int64_t a, std::int64_t b) {
    const std::string_view op = binary.text;
    const auto ua = static_cast<std::uint64_t>(a);
    const auto ub = static_cast<std::uint64_t>(b);
    if (op == "||") return a != 0 || b != 0;
    if (op == "&&") return a != 0 && b != 0;
    if (op == "|") return a | b;
    if (op == "^") return a ^ b;
    if (op == "&") return a & b;
    if (op == "==") return a == b;
    if (op == "!=") return a != b;
    if (op == "<") return a < b;
    if (op == ">") return a > b;
    if (op == "<=") return a <= b;
    if (op == ">=") return a >= b;
    if (binary.is_shift()) {
      failed_ = failed_ || b < 0 || b > 63;
      if (failed_) return 0;
      return op == "<<" ? wrap(ua << ub) : a >> b;
    }
    if (op == "+") return wrap(ua + ub);
    if (op == "-") return wrap(ua - ub);
    if (op == "*") return wrap(ua * ub);
    if (b == 0 || b == -1) {
      failed_ = failed_ || b == 0;
      return op == "/" ? wrap(0 - ua) : 0;
    }
    return op == "/" ? a / b : a % b;
  }

 private:
  [[nodiscard]] bool at(std::string_view text) const {
    return at_ < tokens_.size() && tokens_[at_].kind == TokenKind::Sign && tokens_[at_].text == text;
  }

  std::int64_t unary(const Token& token) {
    if (token.is("!")) return operand() == 0;
    if (token.is("-")) return wrap(0 - static_cast<std::uint64_t>(operand()));
    if (token.is("+")) return operand();
    if (token.is("~")) return ~operand();
    if (token.is("(")) {
      const std::int64_t value = climb_operators(*this);
      failed_ = failed_ || !at(")");
      ++at_;
      return value;
    }
    if (token.kind == TokenKind::Word) return 0;
    std::int64_t value = 0;
    failed_ = failed_ || token.kind != TokenKind::Number || !whole_number(token.text, value);
    return value;
  }

  std::span<const Token> tokens_;
  std::size_t at_ = 0;
  int depth_ = 0;
  bool failed_ = false;
};

}  // namespace

std::optional<std::int64_t> constant_value(std::span<const Token> tokens) { return Evaluator(tokens).run(); }

}  // namespace bip::genom
