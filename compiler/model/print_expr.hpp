// Operators as text, in the languages that code is printed in: the one place that decides symbols and parentheses.
// Walks over the code, names of variables, constants and calls are the printers' own (graph, emit_cpp, exchange).
#pragma once
#include <string>

#include "compiler/model/operators.hpp"

namespace bip {

enum class Dialect : std::uint8_t {
  Bip,     // parentheses that the grammar needs, and around comparisons of comparisons
  Cpp,     // also where a mixture of operators surprises (-Wparentheses)
  Promela  // around every operator
};

/// Text of an expression, and how tightly its outermost operator binds.
struct ExprText {
  std::string text;
  Precedence precedence = Precedence::Primary;
};

[[nodiscard]] std::string parens(const std::string& text);
/// Returns the text, in parentheses if it binds looser than its context allows.
[[nodiscard]] std::string at_least(ExprText expr, Precedence context);

/// Requires an operator of family Sign.
[[nodiscard]] ExprText print_unary(Dialect dialect, Op op, ExprText a);
/// Takes the operands' text over: a chain of n operands costs O(n) where no parentheses are added.
[[nodiscard]] ExprText print_binary(Dialect dialect, Op op, ExprText a, ExprText b);

}  // namespace bip
