// The expression and statement IR: guards, actions, transfers. Small, typed, in tree form, in flat tables.
//
// A piece of code runs over two kinds of variables:
//   Self k   the k-th slot of what owns the code (an atom's parameters then data; a connector's own data);
//   Bind k   the k-th bound variable (connectors: the port variables of all parameters in order, then the exported
//            data that the connector reads; priority guards: the exported data they read).
// Types are checked when the code is built: executors never check again. int wraps at 32 bits; division and % by zero
// and INT_MIN / -1 are faults at the expression's loc; && and || are short-circuit; operands are evaluated left to right.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/base/ids.hpp"
#include "compiler/source/source.hpp"

namespace bip {

enum class Type : std::uint8_t { Int, Bool, Float, String };
[[nodiscard]] const char* name_of(Type type);  // "int" …

using ExprId = Id<struct ExprTag>;
using StmtId = Id<struct StmtTag>;

enum class Op : std::uint8_t {
  ConstInt, ConstBool, ConstFloat, ConstString,  // int_value, int_value 0/1, float_value, int_value = row of strings
  LoadSelf, LoadBind,                            // index
  IntToFloat, Neg, Not, BitNot,                  // a
  Add, Sub, Mul, Div, Mod,                       // a b: int or float (Mod: int)
  BitAnd, BitOr, BitXor,                         // a b: int
  And, Or,                                       // a b: bool, short-circuit
  Eq, Ne, Lt, Gt, Le, Ge                         // a b of one type -> bool; Lt..Ge: int, float
};
[[nodiscard]] const char* name_of(Op op);

/// One expression. type is the result's; for Eq…Ge the operands' type is that of row a.
struct Expr {
  Op op = Op::ConstInt;
  Type type = Type::Int;
  std::uint32_t index = 0;      // LoadSelf, LoadBind
  std::int32_t int_value = 0;   // ConstInt, ConstBool, ConstString
  double float_value = 0;       // ConstFloat
  ExprId a{}, b{};
  Loc loc{};
};

enum class StmtOp : std::uint8_t { StoreSelf, StoreBind, If };
/// One statement. Statements of a body are chained by `next`.
struct Stmt {
  StmtOp op = StmtOp::StoreSelf;
  Type type = Type::Int;        // Store: type of the slot
  std::uint32_t index = 0;
  ExprId value{};               // Store: the value; If: the condition
  StmtId then_body{}, else_body{};  // If: first statements, invalid if empty
  StmtId next{};                // invalid: the last one
  Loc loc{};
};

/// All code of a system, and its string constants (each once).
struct CodeTable {
  IndexVector<ExprId, Expr> exprs;
  IndexVector<StmtId, Stmt> stmts;
  std::vector<std::string> strings;

  /// The row of a string constant, added if new.
  std::uint32_t string(const std::string& text);
};

/// A constant argument or parameter value.
struct Value {
  Type type = Type::Int;
  std::int32_t int_value = 0;   // Int, Bool 0/1, String: row of CodeTable::strings
  double float_value = 0;
  friend bool operator==(const Value&, const Value&) = default;
};

}  // namespace bip
