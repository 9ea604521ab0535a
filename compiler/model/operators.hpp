// Properties of operators, generated from compiler/syntax/ops.def. Constant tables: every answer is one look-up.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "compiler/model/code.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip {

/// Operators that most stages treat alike.
enum class OpFamily : std::uint8_t {
  Constant,
  Load,
  Call,
  Conversion,
  Sign,
  Arithmetic,
  Division,  // may fault for ints
  Bitwise,
  Logic,  // short-circuit
  Equality,
  Order
};
/// How tightly an operator binds, from the loosest. The levels of BIP are those of C++.
enum class Precedence : std::uint8_t {
  Loosest,
  Or,
  And,
  BitOr,
  BitXor,
  BitAnd,
  Equality,
  Relation,
  Sum,
  Product,
  Unary,
  Primary
};
/// The type that all operands have: Number is int or float, Native any but an FFI type.
enum class OperandTypes : std::uint8_t { None, Int, Bool, Number, Native };
/// Own: the row says it (constants, loads, calls). Operand: the operands' type.
enum class ResultType : std::uint8_t { Own, Operand, Bool, Float };

struct OperatorInfo {
  OpFamily family;
  const char* text;    // --emit=model, certificates
  const char* word;    // .bsys; null: a form of its own
  const char* symbol;  // BIP, C++
  Precedence precedence;
  OperandTypes operands;
  ResultType result;
  const char* function;  // C++ function for int; null: the symbol
  const char* promela;   // null: not expressible
};

inline constexpr auto kOperators = std::to_array<OperatorInfo>({
#define BIP_OP_ROW(name, family, text, word, symbol, precedence, operands, result, function, promela, token) \
  {OpFamily::family,   text,     word,   symbol, Precedence::precedence, OperandTypes::operands,             \
   ResultType::result, function, promela},
    BIP_OPS(BIP_OP_ROW)
#undef BIP_OP_ROW
});

/// Returns whether the value is an operator: rows of untrusted tables may hold anything.
[[nodiscard]] constexpr bool is_operator(Op op) { return static_cast<std::size_t>(op) < kOperators.size(); }
[[nodiscard]] constexpr const OperatorInfo& info_of(Op op) { return kOperators[static_cast<std::size_t>(op)]; }
[[nodiscard]] constexpr OpFamily family_of(Op op) { return info_of(op).family; }
[[nodiscard]] constexpr Precedence precedence_of(Op op) { return info_of(op).precedence; }
[[nodiscard]] constexpr const char* symbol_of(Op op) { return info_of(op).symbol; }

/// Operands that an operator takes: 0 (also a call, whose arguments are listed apart), 1 or 2.
[[nodiscard]] constexpr int operand_count(Op op) {
  switch (family_of(op)) {
    case OpFamily::Constant:
    case OpFamily::Load:
    case OpFamily::Call: return 0;
    case OpFamily::Conversion:
    case OpFamily::Sign: return 1;
    case OpFamily::Arithmetic:
    case OpFamily::Division:
    case OpFamily::Bitwise:
    case OpFamily::Logic:
    case OpFamily::Equality:
    case OpFamily::Order: return 2;
  }
  return 0;
}
[[nodiscard]] constexpr bool is_division(Op op) { return family_of(op) == OpFamily::Division; }
[[nodiscard]] constexpr bool is_order(Op op) { return family_of(op) == OpFamily::Order; }
[[nodiscard]] constexpr bool is_comparison(Op op) { return family_of(op) == OpFamily::Equality || is_order(op); }
/// Returns the comparison that is true where this one is false; of ints, not of floats (NaN).
[[nodiscard]] inline Op negation_of(Op op) {
  switch (op) {
    case Op::Eq: return Op::Ne;
    case Op::Ne: return Op::Eq;
    case Op::Lt: return Op::Ge;
    case Op::Gt: return Op::Le;
    case Op::Le: return Op::Gt;
    case Op::Ge:
      return Op::Lt;
      BIP_NO_COMPARISON_OPS(BIP_OP_CASE)
      break;
  }
  BIP_UNREACHABLE("not a comparison");
}
[[nodiscard]] constexpr bool is_load(Op op) { return family_of(op) == OpFamily::Load; }
[[nodiscard]] constexpr bool is_numeric(Type type) { return type == Type::Int || type == Type::Float; }

/// Returns whether the operator takes operands that all have this type.
[[nodiscard]] constexpr bool takes(OperandTypes operands, Type type) {
  switch (operands) {
    case OperandTypes::None: return false;
    case OperandTypes::Int: return type == Type::Int;
    case OperandTypes::Bool: return type == Type::Bool;
    case OperandTypes::Number: return is_numeric(type);
    case OperandTypes::Native: return !is_ffi(type);
  }
  return false;
}
/// Returns the type of an operator's value, given the type of its operands. Not for constants, loads and calls.
[[nodiscard]] constexpr Type result_of(Op op, Type operand) {
  switch (info_of(op).result) {
    case ResultType::Own:
    case ResultType::Operand: return operand;
    case ResultType::Bool: return Type::Bool;
    case ResultType::Float: return Type::Float;
  }
  return operand;
}

}  // namespace bip
