// What operators compute, on values: the one definition for constant evaluation, the interpreter, properties of states
// and the constant domain of the prover. Generated code (jit, emitted C++) computes the same by other means, which
// tests/differential compares.
//
// Bools are 0 and 1, strings are rows of the string table: the comparisons of int serve them. Only the operators that a
// type has reach a function: the others are bugs.
#pragma once
#include <cstdint>

#include "compiler/model/operators.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip {

/// Returns the 32 low bits, as two's complement.
[[nodiscard]] constexpr std::int32_t wrapped(std::uint32_t bits) { return static_cast<std::int32_t>(bits); }

/// Returns whether a / b and a % b are faults.
[[nodiscard]] constexpr bool division_faults(std::int32_t a, std::int32_t b) {
  return b == 0 || (b == -1 && a == INT32_MIN);
}

template <class Number>
[[nodiscard]] inline bool fold_comparison(Op op, Number a, Number b) {
  switch (op) {
    case Op::Eq: return a == b;
    case Op::Ne: return a != b;
    case Op::Lt: return a < b;
    case Op::Gt: return a > b;
    case Op::Le: return a <= b;
    case Op::Ge:
      return a >= b;
      BIP_NO_COMPARISON_OPS(BIP_OP_CASE)
      break;
  }
  BIP_UNREACHABLE("not a comparison");
}

/// Requires, of a division, !division_faults(a, b). The interpreter's step is one of these: a call would cost it 5 %.
[[nodiscard, gnu::always_inline]] inline std::int32_t fold_int(Op op, std::int32_t a, std::int32_t b) {
  const auto x = static_cast<std::uint32_t>(a), y = static_cast<std::uint32_t>(b);
  switch (op) {
    case Op::Add: return wrapped(x + y);
    case Op::Sub: return wrapped(x - y);
    case Op::Mul: return wrapped(x * y);
    // In 64 bits: see rt::quotient.
    case Op::Div: return static_cast<std::int32_t>(static_cast<std::int64_t>(a) / b);
    case Op::Mod: return a % b;
    case Op::BitAnd: return a & b;
    case Op::BitOr: return a | b;
    case Op::BitXor: return a ^ b;
    case Op::And: return a != 0 && b != 0 ? 1 : 0;
    case Op::Or:
      return a != 0 || b != 0 ? 1 : 0;
      BIP_COMPARISON_OPS(BIP_OP_CASE) return fold_comparison(op, a, b) ? 1 : 0;
      BIP_LEAF_OPS(BIP_OP_CASE)
      BIP_UNARY_OPS(BIP_OP_CASE)
      break;
  }
  BIP_UNREACHABLE("not an operator of two ints");
}

[[nodiscard]] inline std::int32_t fold_int(Op op, std::int32_t a) {
  switch (op) {
    case Op::Neg: return wrapped(0u - static_cast<std::uint32_t>(a));
    case Op::Not: return a == 0 ? 1 : 0;
    case Op::BitNot:
      return ~a;
      BIP_LEAF_OPS(BIP_OP_CASE)
      BIP_CONVERSION_OPS(BIP_OP_CASE)
      BIP_BINARY_OPS(BIP_OP_CASE)
      break;
  }
  BIP_UNREACHABLE("not an operator of one int");
}

/// IEEE double, without contraction. Comparisons: fold_comparison.
[[nodiscard]] inline double fold_float(Op op, double a, double b) {
  switch (op) {
    case Op::Add: return a + b;
    case Op::Sub: return a - b;
    case Op::Mul: return a * b;
    case Op::Div:
      return a / b;
      BIP_LEAF_OPS(BIP_OP_CASE)
      BIP_UNARY_OPS(BIP_OP_CASE)
    case Op::Mod:
      BIP_BITWISE_OPS(BIP_OP_CASE)
      BIP_LOGIC_OPS(BIP_OP_CASE)
      BIP_COMPARISON_OPS(BIP_OP_CASE)
      break;
  }
  BIP_UNREACHABLE("not an operator of two floats");
}

}  // namespace bip
