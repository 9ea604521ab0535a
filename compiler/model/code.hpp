// The expression and statement IR: guards, actions, transfers. Small, typed, in tree form, in flat tables.
//
// A piece of code runs over two kinds of variables:
//   Self k   the k-th variable of what owns the code (an atom's parameters then data; a connector's own data);
//   Bind k   the k-th bound variable (connectors: the port variables of all parameters in order, then the exported
//            data that the connector reads; priority guards: the exported data they read).
// Types are checked when the code is built: executors never check again. int wraps at 32 bits; division and % by zero
// and INT_MIN / -1 are faults at the expression's loc; && and || are short-circuit; operands are evaluated left to
// right.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "runtime/include/bip/ids.hpp"
#include "compiler/model/statements.def"
#include "compiler/source/source.hpp"
#include "compiler/syntax/ops.def"

namespace bip {

/// A native type, or from kFirstFfiType on a row of CodeTable::ffi_types.
enum class Type : std::uint16_t { Int, Bool, Float, String };
inline constexpr std::uint16_t kFirstFfiType = 4;
[[nodiscard]] constexpr bool is_ffi(Type type) { return static_cast<std::uint16_t>(type) >= kFirstFfiType; }
[[nodiscard]] constexpr Type ffi_type(std::size_t row) { return static_cast<Type>(kFirstFfiType + row); }
[[nodiscard]] constexpr std::size_t ffi_row(Type type) { return static_cast<std::size_t>(type) - kFirstFfiType; }
[[nodiscard]] const char* name_of(Type type);  // "int" …

using ExprId = Id<struct ExprTag>;
using StmtId = Id<struct StmtTag>;

// ConstInt, ConstBool: int_value; ConstFloat: float_value; ConstString: int_value = row of strings; loads: index;
// Call: index = row of functions, int_value = first row of args; unary operators: a; binary ones: a, b.
enum class Op : std::uint8_t {
#define BIP_OP_NAME(name, ...) name,
  BIP_OPS(BIP_OP_NAME)
#undef BIP_OP_NAME
};
[[nodiscard]] const char* name_of(Op op);

/// One expression. type is the result's; for Eq…Ge the operands' type is that of row a.
struct Expr {
  Op op = Op::ConstInt;
  Type type = Type::Int;
  std::uint32_t index = 0;     // LoadSelf, LoadBind
  std::int32_t int_value = 0;  // ConstInt, ConstBool, ConstString
  double float_value = 0;      // ConstFloat
  ExprId a{}, b{};
  Loc loc{};
};

enum class StmtOp : std::uint8_t {
#define BIP_STATEMENT_NAME(name, ...) name,
  BIP_STATEMENTS(BIP_STATEMENT_NAME)
#undef BIP_STATEMENT_NAME
};
/// One statement. Statements of a body are chained by `next`.
struct Stmt {
  StmtOp op = StmtOp::StoreSelf;
  Type type = Type::Int;  // Store: type of the variable
  std::uint32_t index = 0;
  ExprId value{};                   // Store: the value; If: the condition; Call: the call, whose result is dropped
  StmtId then_body{}, else_body{};  // If: first statements, invalid if empty
  StmtId next{};                    // invalid: the last one
  Loc loc{};
};

/// A type of data whose values are C++ objects: `extern data type name refine … as "cpp"`.
struct FfiType {
  std::string name;
  std::string cpp;            // "std::list<int>"
  std::vector<Type> refines;  // what a value can stand for
  Loc loc{};
};
enum class FunctionKind : std::uint8_t { Function, Operator, Cast, Draw };
struct FunctionParam {
  Type type = Type::Int;      // of the argument, which may refine the prototype's
  bool by_reference = false;  // int, float, FFI type: C++ may change the variable that is given
  friend bool operator==(const FunctionParam&, const FunctionParam&) = default;
};
/// A C++ function, operator or conversion as one kind of call uses it; or a distribution of std.chance, of which the
/// first parameter is the atom's generator, by reference (runtime/include/bip/draws.hpp).
struct Function {
  FunctionKind kind = FunctionKind::Function;
  std::string name;       // "min"; of an operator its sign
  bool is_const = false;  // called where nothing may change: `const_name` is preferred
  bool has_result = true;
  Type result = Type::Int;
  std::vector<FunctionParam> params;
  Loc loc{};  // of the prototype
};
/// A file that `@cpp(include, src, obj)` names, and the folder of the .bip that says so.
struct CppFile {
  std::string folder, name;
  friend bool operator==(const CppFile&, const CppFile&) = default;
};
struct FfiFiles {
  std::vector<CppFile> includes, sources, objects;
};

/// All code of a system, and its string constants (each once).
struct CodeTable {
  IndexVector<ExprId, Expr> exprs;
  IndexVector<StmtId, Stmt> stmts;
  std::vector<std::string> strings;
  std::vector<FfiType> ffi_types;
  std::vector<Function> functions;
  std::vector<ExprId> args;  // of calls; an argument by reference is a load
  FfiFiles cpp;

  /// The row of a string constant, added if new.
  std::uint32_t string(const std::string& text);
  /// Returns whether there is C++ behind some function or type: distributions are none.
  [[nodiscard]] bool has_cpp() const;
  [[nodiscard]] bool has_draws() const;
  /// The name of a function or type of C++. Requires has_cpp().
  [[nodiscard]] const std::string& first_cpp() const;
  /// "int", or the name of an FFI type.
  [[nodiscard]] std::string type_name(Type type) const;
  /// The arguments of a call.
  [[nodiscard]] std::span<const ExprId> args_of(const Expr& call) const {
    return {args.data() + call.int_value, functions[call.index].params.size()};
  }
};

/// A constant argument or parameter value.
struct Value {
  Type type = Type::Int;
  std::int32_t int_value = 0;  // Int, Bool 0/1, String: row of CodeTable::strings
  double float_value = 0;
  friend bool operator==(const Value&, const Value&) = default;
};

}  // namespace bip
