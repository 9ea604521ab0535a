// See print_expr.hpp.
#include "compiler/model/print_expr.hpp"

#include <utility>

namespace bip {

namespace {

enum class Operand : std::uint8_t { Left, Right };

// A C++ operand: without parentheses if it binds tighter and -Wparentheses does not warn of the two operators.
std::string cpp_operand(ExprText t, Op op, Operand side) {
  const bool is_left = side == Operand::Left;
  const Precedence level = precedence_of(op);
  const bool is_not = t.precedence == Precedence::Unary && t.text[0] == '!';
  if (is_left && is_not && is_comparison(op)) return parens(t.text);
  const bool chain = t.precedence == level && is_left && !is_comparison(op);
  const Precedence harmless = level <= Precedence::And ? Precedence::Equality : Precedence::Sum;
  const bool tighter = t.precedence > level && t.precedence >= harmless;
  return chain || tighter ? std::move(t.text) : parens(t.text);
}

// Comparisons do not chain; of other operators the left operand may be one of the same level.
std::string bip_operand(ExprText t, Op op, Operand side) {
  if (is_comparison(op)) return at_least(std::move(t), Precedence::Sum);
  const int level = static_cast<int>(precedence_of(op));
  return at_least(std::move(t), static_cast<Precedence>(side == Operand::Left ? level : level + 1));
}

}  // namespace

std::string parens(const std::string& text) { return "(" + text + ")"; }

std::string at_least(ExprText expr, Precedence context) {
  return expr.precedence < context ? parens(expr.text) : std::move(expr.text);
}

ExprText print_unary(Dialect dialect, Op op, ExprText a) {
  const OperatorInfo& info = info_of(op);
  switch (dialect) {
    case Dialect::Bip: {
      // `- -x` would be read as it stands, but not by people.
      const Precedence context = op == Op::Neg ? Precedence::Primary : Precedence::Unary;
      return {info.symbol + at_least(std::move(a), context), Precedence::Unary};
    }
    case Dialect::Cpp:
      // Parenthesised as a whole: `!x == y` and `- -x` read badly.
      return {info.symbol + at_least(std::move(a), Precedence::Primary), Precedence::Unary};
    case Dialect::Promela: return {parens(info.promela + a.text)};
  }
  BIP_UNREACHABLE("dialect");
}

ExprText print_binary(Dialect dialect, Op op, ExprText a, ExprText b) {
  const OperatorInfo& info = info_of(op);
  std::string text;
  switch (dialect) {
    case Dialect::Bip:
      text = bip_operand(std::move(a), op, Operand::Left);
      text.append(" ").append(info.symbol).append(" ").append(bip_operand(std::move(b), op, Operand::Right));
      return {std::move(text), info.precedence};
    case Dialect::Cpp:
      text = cpp_operand(std::move(a), op, Operand::Left);
      text.append(" ").append(info.symbol).append(" ").append(cpp_operand(std::move(b), op, Operand::Right));
      return {std::move(text), info.precedence};
    case Dialect::Promela: return {"(" + a.text + " " + info.promela + " " + b.text + ")"};
  }
  BIP_UNREACHABLE("dialect");
}

}  // namespace bip
