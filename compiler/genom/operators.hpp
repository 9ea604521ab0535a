// The binary operators of constant expressions, and the order in which they bind: those of C, of which IDL has some
// with the same order (ISO C11, 6.5; OMG IDL 4.2, 7.4.1.4.3).
//
// Expressions are read by precedence climbing (K. Clarke, "The top-down parsing of expressions", 1986): linear, and no
// deeper on the stack than levels and what `operand` nests.
#pragma once
#include <string_view>
#include <utility>

#include "compiler/genom/tokens.hpp"

namespace bip::genom {

/// Larger numbers bind tighter.
enum class Precedence : int { None, LogicalOr, LogicalAnd, Or, Xor, And, Equality, Comparison, Shift, Sum, Product };

struct BinaryOperator {
  std::string_view text;
  Precedence precedence = Precedence::None;  // None: there is no operator
  [[nodiscard]] bool is_shift() const { return precedence == Precedence::Shift; }
};

/// The operator that begins with the token `first`, before `second`. `<<` and `>>` are two tokens, since types end with
/// `>>`.
[[nodiscard]] BinaryOperator binary_operator_at(const Token& first, const Token& second);

/// Reads operators that bind at least as tight as `lowest`, and their operands. `Reader` has `operand()`,
/// `next_operator()`, which ends the expression by None, `take(op)`, which returns the place of the operator, and
/// `apply(op, place, left, right)`.
template <class Reader>
decltype(std::declval<Reader&>().operand()) climb_operators(Reader& reader, Precedence lowest = Precedence::LogicalOr) {
  auto left = reader.operand();
  for (BinaryOperator op = reader.next_operator(); op.precedence != Precedence::None && op.precedence >= lowest;
       op = reader.next_operator()) {
    const auto place = reader.take(op);
    // All of them associate to the left.
    auto right = climb_operators(reader, static_cast<Precedence>(static_cast<int>(op.precedence) + 1));
    left = reader.apply(op, place, std::move(left), std::move(right));
  }
  return left;
}

}  // namespace bip::genom
