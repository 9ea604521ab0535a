// See condition.hpp. Precedence climbing; arithmetic wraps, because overflow in a description is meaningless.
#include "compiler/genom/condition.hpp"

#include <string_view>

namespace bip::genom {
namespace {

struct Operator {
  std::string_view text;
  int level;
};
constexpr Operator kOperators[] = {{"||", 1}, {"&&", 2}, {"|", 3}, {"^", 4},  {"&", 5},  {"==", 6},
                                   {"!=", 6}, {"<", 7},  {">", 7}, {"<=", 7}, {">=", 7}, {"<<", 8},
                                   {">>", 8}, {"+", 9},  {"-", 9}, {"*", 10}, {"/", 10}, {"%", 10}};
constexpr int kMaxConditionDepth = 100;

std::int64_t wrap(std::uint64_t value) { return static_cast<std::int64_t>(value); }

class Evaluator {
 public:
  explicit Evaluator(std::span<const Token> tokens) : tokens_(tokens) {}

  std::optional<std::int64_t> run() {
    const std::int64_t value = binary(1, 0);
    if (failed_ || at_ != tokens_.size()) return std::nullopt;
    return value;
  }

 private:
  [[nodiscard]] bool at(std::string_view text) const {
    return at_ < tokens_.size() && tokens_[at_].kind == TokenKind::Sign && tokens_[at_].text == text;
  }

  // The operator that is next; empty: there is none. `<<` and `>>` are two tokens, since types end with `>>`.
  [[nodiscard]] std::string_view next() const {
    if (at_ >= tokens_.size() || tokens_[at_].kind != TokenKind::Sign) return {};
    const Token& token = tokens_[at_];
    if (at_ + 1 >= tokens_.size() || !tokens_[at_ + 1].is(token.text) ||
        tokens_[at_ + 1].range.begin != token.range.end)
      return token.text;
    return token.text == "<" ? "<<" : token.text == ">" ? ">>" : token.text;
  }

  static int level_of(std::string_view op) {
    for (const Operator& o : kOperators) {
      if (o.text == op) return o.level;
    }
    return 0;
  }

  std::int64_t binary(int lowest, int depth) {
    std::int64_t left = unary(depth);
    for (int rank = level_of(next()); !failed_ && rank >= lowest && rank > 0; rank = level_of(next())) {
      const std::string_view op = next();
      at_ += op == "<<" || op == ">>" ? 2 : 1;
      left = apply(op, left, binary(rank + 1, depth + 1));
    }
    return left;
  }

  std::int64_t apply(std::string_view op, std::int64_t a, std::int64_t b) {
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
    if (op == "<<" || op == ">>") {
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

  std::int64_t unary(int depth) {
    if (depth > kMaxConditionDepth || at_ >= tokens_.size()) {
      failed_ = true;
      return 0;
    }
    const Token& token = tokens_[at_++];
    if (token.is("!")) return unary(depth + 1) == 0;
    if (token.is("-")) return wrap(0 - static_cast<std::uint64_t>(unary(depth + 1)));
    if (token.is("+")) return unary(depth + 1);
    if (token.is("~")) return ~unary(depth + 1);
    if (token.is("(")) {
      const std::int64_t value = binary(1, depth + 1);
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
  bool failed_ = false;
};

}  // namespace

std::optional<std::int64_t> constant_value(std::span<const Token> tokens) { return Evaluator(tokens).run(); }

}  // namespace bip::genom
