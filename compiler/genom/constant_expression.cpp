// See constant_expression.hpp.
#include "compiler/genom/constant_expression.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "compiler/genom/operators.hpp"

namespace bip::genom::idl {
namespace {

constexpr int kMaxExpressionDepth = 50;
constexpr WideInteger kLowest = std::numeric_limits<std::int64_t>::min();
constexpr WideInteger kHighest = std::numeric_limits<std::uint64_t>::max();

bool is_integer(const Value& v) { return v.kind == ValueKind::Integer; }
bool is_number(const Value& v) { return is_integer(v) || v.kind == ValueKind::Real; }
double as_real(const Value& v) { return is_integer(v) ? static_cast<double>(v.integer) : v.real; }

// 12, 0x1f, 10u; decimal even with zeros in front.
bool read_integer(std::string_view text, std::uint64_t& into) {
  const bool is_hex = text.starts_with("0x") || text.starts_with("0X");
  if (is_hex) text.remove_prefix(2);
  while (!text.empty() && std::string_view("uUlL").find(text.back()) != std::string_view::npos) text.remove_suffix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), into, is_hex ? 16 : 10);
  return error == std::errc() && end == text.data() + text.size();
}

// 1.5, 2., .5, 1e-3, 0.5f, 2d.
bool read_real(std::string_view text, double& into) {
  if (text.starts_with("0x") || text.starts_with("0X")) return false;
  if (!text.empty() && std::string_view("fFdDlL").find(text.back()) != std::string_view::npos) text.remove_suffix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), into);
  return error == std::errc() && end == text.data() + text.size();
}

class ExpressionReader {
 public:
  ExpressionReader(Cursor& in, const FindConstant& find, const ExpressionContext& context)
      : in_(in), find_(find), context_(context), in_angles_(context.ends_with_angle) {}

  std::optional<Value> run() {
    const std::size_t begin = in_.position();
    const SourceRange first = in_.peek().range;
    Value value = climb_operators(*this);
    if (is_broken_) return std::nullopt;
    if (value.kind == ValueKind::Name && (!context_.may_be_enumerator || !is_path_alone(begin))) unknown(value);
    value.range = first;
    return value;
  }

  // ---- of climb_operators

  Value operand() {
    struct Depth {
      int& depth;
      explicit Depth(int& d) : depth(++d) {}
      ~Depth() { --depth; }
      Depth(const Depth&) = delete;
      Depth& operator=(const Depth&) = delete;
    };
    const Depth guard(depth_);
    if (depth_ > kMaxExpressionDepth) return broken("an expression that is not so deep");
    return unary();
  }

  // IDL has neither comparisons nor logical operators.
  [[nodiscard]] BinaryOperator next_operator() const {
    if (is_broken_ || (in_angles_ && in_.peek().is(">"))) return {};
    const BinaryOperator op = binary_operator_at(in_.peek(), in_.peek(1));
    const bool is_of_idl = op.precedence >= Precedence::Or && op.precedence != Precedence::Equality &&
                           op.precedence != Precedence::Comparison;
    return is_of_idl ? op : BinaryOperator{};
  }

  SourceRange take(const BinaryOperator& op) {
    const SourceRange range = in_.take().range;
    if (op.is_shift()) in_.take();
    return range;
  }

  Value apply(const BinaryOperator& op, SourceRange range, Value a, Value b) {
    for (Value* const v : {&a, &b}) {
      if (v->kind == ValueKind::Name) unknown(*v);
    }
    if (is_broken_ || a.kind == ValueKind::Error || b.kind == ValueKind::Error) return error_at(range);
    const bool takes_real = op.precedence >= Precedence::Sum && op.text != "%";
    for (const Value* const v : {&a, &b}) {
      if (takes_real ? !is_number(*v) : !is_integer(*v))
        return no_value(range, fmt::format("`{}` takes {}, this is {}", op.text, takes_real ? "numbers" : "integers",
                                           name_of(v->kind)));
    }
    if ((op.text == "/" || op.text == "%") && as_real(b) == 0) return no_value(range, "it divides by zero");
    return is_integer(a) && is_integer(b) ? of_integers(op, range, a.integer, b.integer)
                                          : of_reals(op, range, as_real(a), as_real(b));
  }

 private:
  // Did the reader take nothing but the names of one path?
  [[nodiscard]] bool is_path_alone(std::size_t begin) const { return in_.position() - begin == path_length_; }

  static Value error_at(SourceRange range) { return {.kind = ValueKind::Error, .range = range}; }

  Value no_value(SourceRange range, const std::string& reason) {
    in_.diags().report(Diag::kB6031, range, reason);
    return error_at(range);
  }

  void unknown(Value& value) {
    in_.diags().report(Diag::kB6008, value.range, "constant or enumerator", value.text);
    value.kind = ValueKind::Error;
  }

  Value broken(std::string_view expected) {
    if (!is_broken_) in_.unexpected(expected);
    is_broken_ = true;
    return error_at(in_.peek().range);
  }

  Value of_integers(const BinaryOperator& o, SourceRange range, WideInteger a, WideInteger b) {
    if (o.is_shift() && (b < 0 || b > 63))
      return no_value(range, fmt::format("`{}` shifts by {}, and can by 0 to 63", o.text, b));
    WideInteger result = 0;
    bool overflows = false;
    if (o.text == "|") result = a | b;
    else if (o.text == "^") result = a ^ b;
    else if (o.text == "&") result = a & b;
    else if (o.text == "<<") overflows = __builtin_mul_overflow(a, WideInteger{1} << static_cast<int>(b), &result);
    else if (o.text == ">>") result = a >> static_cast<int>(b);
    else if (o.text == "+") result = a + b;
    else if (o.text == "-") result = a - b;
    else if (o.text == "*") overflows = __builtin_mul_overflow(a, b, &result);
    else result = o.text == "/" ? a / b : a % b;
    return in_64_bits(o.text, range, result, overflows);
  }

  Value in_64_bits(std::string_view sign, SourceRange range, WideInteger result, bool overflows = false) {
    if (overflows || result < kLowest || result > kHighest)
      return no_value(range, fmt::format("the result of `{}` needs more than 64 bits", sign));
    return {.kind = ValueKind::Integer, .range = range, .integer = result};
  }

  Value of_reals(const BinaryOperator& o, SourceRange range, double a, double b) {
    const double result = o.text == "+" ? a + b : o.text == "-" ? a - b : o.text == "*" ? a * b : a / b;
    if (!std::isfinite(result))
      return no_value(range, fmt::format("the result of `{}` is larger than any floating-point number", o.text));
    return {.kind = ValueKind::Real, .range = range, .real = result};
  }

  Value unary() {
    const Token token = in_.peek();
    if (token.is("-") || token.is("+") || token.is("~")) {
      in_.take();
      return apply_unary(token, operand());
    }
    if (in_.accept("(")) {
      const bool outer = std::exchange(in_angles_, false);
      Value value = climb_operators(*this);
      in_angles_ = outer;
      if (!is_broken_ && !in_.accept(")")) return broken("`)`");
      return value;
    }
    switch (token.kind) {
      case TokenKind::Number: return number();
      case TokenKind::String: return text();
      case TokenKind::Word: return name();
      case TokenKind::Sign: return token.is("::") ? name() : broken("a value");
      case TokenKind::End: break;
    }
    return broken("a value");
  }

  Value apply_unary(const Token& sign, Value v) {
    if (v.kind == ValueKind::Name) unknown(v);
    if (is_broken_ || v.kind == ValueKind::Error) return error_at(sign.range);
    const bool takes_real = !sign.is("~");
    if (takes_real ? !is_number(v) : !is_integer(v))
      return no_value(sign.range, fmt::format("`{}` takes {}, this is {}", sign.text,
                                              takes_real ? "a number" : "an integer", name_of(v.kind)));
    if (sign.is("+")) return v;
    if (!is_integer(v)) return {.kind = ValueKind::Real, .range = sign.range, .real = -v.real};
    if (sign.is("-")) return in_64_bits(sign.text, sign.range, -v.integer);
    const int bits = context_.unsigned_bits;
    return in_64_bits(sign.text, sign.range, (bits == 0 ? 0 : WideInteger{1} << bits) - v.integer - 1);
  }

  Value number() {
    const Token& token = in_.take();
    std::uint64_t whole = 0;
    if (read_integer(token.text, whole))
      return {.kind = ValueKind::Integer, .range = token.range, .integer = WideInteger{whole}};
    double real = 0;
    if (read_real(token.text, real)) return {.kind = ValueKind::Real, .range = token.range, .real = real};
    return no_value(token.range, fmt::format("`{}` is no number of 64 bits", token.text));
  }

  // Adjacent strings join.
  Value text() {
    Value value{.kind = ValueKind::Text, .range = in_.peek().range};
    while (in_.peek().kind == TokenKind::String) value.text += in_.take().text;
    return value;
  }

  // [::] a::b::c
  Value name() {
    const std::size_t begin = in_.position();
    const SourceRange range = in_.peek().range;
    in_.accept("::");
    std::string path;
    do {
      if (in_.peek().kind != TokenKind::Word) return broken("a name");
      path += (path.empty() ? "" : "::") + std::string(in_.take().text);
    } while (in_.accept("::"));
    path_length_ = in_.position() - begin;
    if (path == "TRUE" || path == "FALSE")
      return {.kind = ValueKind::Boolean, .range = range, .boolean = path == "TRUE"};
    std::optional<Value> known = find_(path);
    if (!known) {
      // A path of one name may be one of the parameter's type, which the scope here does not have.
      const std::size_t last = path.rfind(':');
      return {.kind = ValueKind::Name,
              .range = range,
              .text = last == std::string::npos ? std::move(path) : path.substr(last + 1)};
    }
    known->range = range;
    return std::move(*known);
  }

  Cursor& in_;
  const FindConstant& find_;
  ExpressionContext context_;
  bool in_angles_;
  bool is_broken_ = false;
  int depth_ = 0;
  std::size_t path_length_ = 0;  // in tokens, of the last name
};

}  // namespace

std::optional<Value> read_constant_expression(Cursor& in, const FindConstant& find, const ExpressionContext& context) {
  return ExpressionReader(in, find, context).run();
}

}  // namespace bip::genom::idl
