// Constant evaluation with the arithmetic of code.hpp.
#include "compiler/model/evaluate.hpp"

#include "compiler/base/assert.hpp"

namespace bip::model {

namespace {

std::int32_t wrap(std::int64_t v) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(v)));
}

Value truth(bool b) { return {Type::Bool, b ? 1 : 0, 0}; }

template <class T>
Value compare(Op op, T a, T b) {
  switch (op) {
    case Op::Eq: return truth(a == b);
    case Op::Ne: return truth(a != b);
    case Op::Lt: return truth(a < b);
    case Op::Gt: return truth(a > b);
    case Op::Le: return truth(a <= b);
    default: return truth(a >= b);
  }
}

Evaluated arithmetic(Op op, const Value& a, const Value& b) {
  BIP_ASSERT(a.type == Type::Int || a.type == Type::Float, "arithmetic on type {}", a.type);
  if (a.type == Type::Float) {
    const double x = a.float_value, y = b.float_value;
    return {{Type::Float, 0, op == Op::Add ? x + y : op == Op::Sub ? x - y : op == Op::Mul ? x * y : x / y}};
  }
  const std::int64_t x = a.int_value, y = b.int_value;
  switch (op) {
    case Op::Add: return {{Type::Int, wrap(x + y), 0}};
    case Op::Sub: return {{Type::Int, wrap(x - y), 0}};
    case Op::Mul: return {{Type::Int, wrap(x * y), 0}};
    case Op::BitAnd: return {{Type::Int, wrap(x & y), 0}};
    case Op::BitOr: return {{Type::Int, wrap(x | y), 0}};
    case Op::BitXor: return {{Type::Int, wrap(x ^ y), 0}};
    default: break;
  }
  if (y == 0) return {{Type::Int, 0, 0}, Fault::DivisionByZero};
  if (x == INT32_MIN && y == -1) return {{Type::Int, 0, 0}, Fault::DivisionOverflow};
  return {{Type::Int, wrap(op == Op::Div ? x / y : x % y), 0}};
}

}  // namespace

Evaluated evaluate(const CodeTable& code, ExprId id, std::span<const Value> self) {
  const Expr& e = code.exprs[id];
  switch (e.op) {
    case Op::ConstInt:
    case Op::ConstBool:
    case Op::ConstString:
    case Op::ConstFloat: return {{e.type, e.int_value, e.float_value}};
    case Op::LoadSelf:
      BIP_ASSERT(e.index < self.size(), "variable {} of {}", e.index, self.size());
      BIP_ASSERT(self[e.index].type == e.type, "variable {} has the type {} that the code was built for", e.index,
                 e.type);
      return {self[e.index]};
    case Op::LoadBind: BIP_UNREACHABLE("a constant expression reads a bound variable");
    case Op::Call: return {{e.type, 0, 0}, Fault::Call, id};
    default: break;
  }
  const Evaluated a = evaluate(code, e.a, self);
  if (a.fault != Fault::None) return a;
  switch (e.op) {
    case Op::IntToFloat: return {{Type::Float, 0, static_cast<double>(a.value.int_value)}};
    case Op::Neg:
      return a.value.type == Type::Float
                 ? Evaluated{{Type::Float, 0, -a.value.float_value}}
                 : Evaluated{{Type::Int, wrap(-static_cast<std::int64_t>(a.value.int_value)), 0}};
    case Op::Not: return {truth(a.value.int_value == 0)};
    case Op::BitNot: return {{Type::Int, ~a.value.int_value, 0}};
    case Op::And:
      if (a.value.int_value == 0) return a;
      return evaluate(code, e.b, self);
    case Op::Or:
      if (a.value.int_value != 0) return a;
      return evaluate(code, e.b, self);
    default: break;
  }
  const Evaluated b = evaluate(code, e.b, self);
  if (b.fault != Fault::None) return b;
  BIP_ASSERT(a.value.type == b.value.type, "operands of {} have one type", e.op);
  if (e.op >= Op::Eq) {
    return {a.value.type == Type::Float ? compare(e.op, a.value.float_value, b.value.float_value)
                                        : compare(e.op, a.value.int_value, b.value.int_value)};
  }
  Evaluated result = arithmetic(e.op, a.value, b.value);
  if (result.fault != Fault::None) result.at = id;
  return result;
}

}  // namespace bip::model
