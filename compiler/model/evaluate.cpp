// Constant evaluation with the arithmetic of code.hpp.
#include "compiler/model/evaluate.hpp"

#include "compiler/model/fold.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

namespace {

Value int_value(std::int32_t value) { return {Type::Int, value, 0}; }
Value bool_value(bool value) { return {Type::Bool, value ? 1 : 0, 0}; }
Value float_value(double value) { return {Type::Float, 0, value}; }

Value compare(Op op, const Value& a, const Value& b) {
  return bool_value(a.type == Type::Float ? fold_comparison(op, a.float_value, b.float_value)
                                          : fold_comparison(op, a.int_value, b.int_value));
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
    case Op::Call:
      return {{e.type, 0, 0}, Fault::Call, id};
      BIP_UNARY_OPS(BIP_OP_CASE)
      BIP_BINARY_OPS(BIP_OP_CASE)
      break;
  }
  const Evaluated left = evaluate(code, e.a, self);
  if (left.fault != Fault::None) return left;
  const Value& a = left.value;
  const bool is_float = a.type == Type::Float;
  switch (family_of(e.op)) {
    case OpFamily::Constant:
    case OpFamily::Load:
    case OpFamily::Call: break;
    case OpFamily::Conversion: return {float_value(static_cast<double>(a.int_value))};
    case OpFamily::Sign:
      return {is_float ? float_value(-a.float_value) : Value{.type = a.type, .int_value = fold_int(e.op, a.int_value)}};
    case OpFamily::Logic:
      if ((a.int_value != 0) == (e.op == Op::Or)) return left;
      return evaluate(code, e.b, self);
    case OpFamily::Arithmetic:
    case OpFamily::Division:
    case OpFamily::Bitwise:
    case OpFamily::Equality:
    case OpFamily::Order: break;
  }
  const Evaluated right = evaluate(code, e.b, self);
  if (right.fault != Fault::None) return right;
  const Value& b = right.value;
  BIP_ASSERT(a.type == b.type, "operands of {} have one type", e.op);
  if (is_comparison(e.op)) return {compare(e.op, a, b)};
  BIP_ASSERT(is_numeric(a.type), "arithmetic on type {}", a.type);
  if (is_float) return {float_value(fold_float(e.op, a.float_value, b.float_value))};
  if (is_division(e.op) && division_faults(a.int_value, b.int_value))
    return {int_value(0), b.int_value == 0 ? Fault::DivisionByZero : Fault::DivisionOverflow, id};
  return {int_value(fold_int(e.op, a.int_value, b.int_value))};
}

}  // namespace bip::model
