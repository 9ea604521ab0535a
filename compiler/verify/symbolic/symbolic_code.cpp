// See symbolic_code.hpp. Recursion follows the code's trees, whose depth the parser and .bsys reader bound.
#include "compiler/verify/symbolic/symbolic_code.hpp"

#include <limits>

namespace bip::verify {

Word SymbolicCode::any(Type type) {
  if (!is_followed(type)) return {};
  if (type == Type::Bool) return word_of_bool(aig_.make_input());
  Word w;
  for (int k = 0; k < 32; ++k) w.push_back(aig_.make_input());
  return w;
}

Word SymbolicCode::merged(Signal condition, const Word& yes, const Word& no, Type type) {
  if (condition == kTrue) return yes;
  if (condition == kFalse) return no;
  if (yes.empty() || no.empty()) return is_followed(type) ? any(type) : Word{};
  return make_ite(aig_, condition, yes, no);
}

Word apply(Aig& c, Op op, const Word& a, const Word& b) {
  switch (op) {
    case Op::Add: return add(c, a, b);
    case Op::Sub: return subtract(c, a, b);
    case Op::Mul: return multiply(c, a, b);
    case Op::BitAnd: return bitwise_and(c, a, b);
    case Op::BitOr: return bitwise_or(c, a, b);
    case Op::BitXor: return bitwise_xor(c, a, b);
    case Op::And: return word_of_bool(c.make_and(a[0], b[0]));
    case Op::Or: return word_of_bool(c.make_or(a[0], b[0]));
    case Op::Eq: return word_of_bool(equal(c, a, b));
    case Op::Ne: return word_of_bool(negated(equal(c, a, b)));
    case Op::Lt: return word_of_bool(less(c, a, b));
    case Op::Gt: return word_of_bool(less(c, b, a));
    case Op::Le: return word_of_bool(negated(less(c, b, a)));
    case Op::Ge:
      return word_of_bool(negated(less(c, a, b)));
      BIP_LEAF_OPS(BIP_OP_CASE)
      BIP_UNARY_OPS(BIP_OP_CASE)
      BIP_DIVISION_OPS(BIP_OP_CASE)
      break;
  }
  BIP_UNREACHABLE("not an operator of two words");
}

Word apply(Aig& c, Op op, const Word& a) {
  switch (op) {
    case Op::Neg: return negate(c, a);
    case Op::Not: return word_of_bool(negated(a[0]));
    case Op::BitNot:
      return complement(a);
      BIP_LEAF_OPS(BIP_OP_CASE)
      BIP_CONVERSION_OPS(BIP_OP_CASE)
      BIP_BINARY_OPS(BIP_OP_CASE)
      break;
  }
  BIP_UNREACHABLE("not an operator of one word");
}

Word SymbolicCode::constant(const Expr& e) {
  if (e.type == Type::Float) return {};
  return e.type == Type::Bool ? word_of_bool(e.int_value != 0 ? kTrue : kFalse) : word_of(e.int_value);
}

Word SymbolicCode::load(const Expr& e, SymbolicPoint& at) {
  return e.op == Op::LoadSelf ? at.variables.self(e.index) : at.variables.bind(e.index);
}

// Any value that the distribution may have: exact for ints and bools, but for weights of 0 that are no constants. The
// generator is a float, which is not followed.
Word SymbolicCode::drawn(const Expr& e, SymbolicPoint& at) {
  const Function& function = code_.functions[e.index];
  const std::span<const ExprId> args = code_.args_of(e).subspan(1);
  std::vector<Word> words;
  for (const ExprId arg : args) words.push_back(evaluate(arg, at));
  if (function.name == "uniform" && e.type == Type::Int) {
    const Word &low = words[0], &high = words[1];
    at.fault = aig_.make_or(at.fault, aig_.make_and(at.condition, less(aig_, high, low)));
    const Word value = any(Type::Int);
    const Signal is_within = aig_.make_and(negated(less(aig_, value, low)), negated(less(aig_, high, value)));
    return make_ite(aig_, is_within, value, low);
  }
  const auto is_constant = [&](ExprId arg) { return code_.exprs[arg].op == Op::ConstFloat; };
  const auto is_number = [&](std::size_t k) { return e.type != Type::Int || k % 2 == 1; };
  bool is_known = true;
  for (std::size_t k = 0; k < args.size(); ++k) is_known &= !is_number(k) || is_constant(args[k]);
  // Constants were checked when the model was built; other floats are not followed.
  if (!is_known) {
    note(e.loc, "what `" + function.name + "` is given");
    at.fault = aig_.make_or(at.fault, aig_.make_and(at.condition, aig_.make_input()));
  }
  if (e.type == Type::Float) return {};
  if (e.type == Type::Bool) {
    const double share = is_known ? code_.exprs[args[0]].float_value : 0.5;
    return share == 0 ? word_of_bool(kFalse) : share == 1 ? word_of_bool(kTrue) : any(Type::Bool);
  }
  Word value;
  for (std::size_t k = 0; k < args.size(); k += 2) {
    if (is_known && code_.exprs[args[k + 1]].float_value == 0) continue;
    value = value.empty() ? words[k] : make_ite(aig_, aig_.make_input(), words[k], value);
  }
  return value;
}

Word SymbolicCode::call(const Expr& e, SymbolicPoint& at) {
  if (code_.functions[e.index].kind == FunctionKind::Draw) return drawn(e, at);
  note(e.loc, "a call of `" + code_.functions[e.index].name + '`');
  pass_arguments(e, at);
  return any(e.type);
}

void SymbolicCode::forget(const Expr& load, SymbolicPoint& at) {
  const auto& set = load.op == Op::LoadSelf ? at.variables.set_self : at.variables.set_bind;
  if (set) set(load.index, any(load.type));
}

Word SymbolicCode::divided(const Expr& e, const Word& a, const Word& b, SymbolicPoint& at) {
  if (e.type != Type::Int) return {};
  if (a.empty() || b.empty()) {
    at.fault = aig_.make_or(at.fault, aig_.make_and(at.condition, aig_.make_input()));
    return any(Type::Int);
  }
  const Signal by_zero = equal(aig_, b, word_of(0));
  const Signal by_minus_one = equal(aig_, b, word_of(-1));
  const Signal of_least = equal(aig_, a, word_of(std::numeric_limits<std::int32_t>::min()));
  const Signal overflows = aig_.make_and(of_least, by_minus_one);
  at.fault = aig_.make_or(at.fault, aig_.make_and(at.condition, aig_.make_or(by_zero, overflows)));
  const Division d = divide(aig_, a, b);
  return e.op == Op::Div ? d.quotient : d.remainder;
}

Word SymbolicCode::binary(const Expr& e, const Word& a, const Word& b, SymbolicPoint& at) {
  if (is_division(e.op)) return divided(e, a, b, at);
  if (a.empty() || b.empty()) {
    if (e.type == Type::Bool) note(e.loc, "a comparison of values that are not followed");
    return any(e.type);
  }
  return apply(aig_, e.op, a, b);
}

Word SymbolicCode::unary(const Expr& e, const Word& a, SymbolicPoint&) {
  if (e.op == Op::IntToFloat) return {};
  return a.empty() ? any(e.type) : apply(aig_, e.op, a);
}

Word SymbolicCode::logic(const Expr& e, SymbolicPoint& at) {
  Word a = evaluate(e.a, at);
  if (a.empty()) a = any(Type::Bool);
  const Signal goes_on = e.op == Op::And ? a[0] : negated(a[0]);
  if (goes_on == kFalse) return a;
  SymbolicPoint second{at.variables, aig_.make_and(at.condition, goes_on), at.fault};
  Word b = evaluate(e.b, second);
  if (b.empty()) b = any(Type::Bool);
  return apply(aig_, e.op, a, b);
}

Signal SymbolicCode::test(ExprId guard, const Variables& variables, Signal condition, Signal& fault) {
  if (!guard.is_valid()) return kTrue;
  SymbolicPoint at{variables, condition, fault};
  const Word w = evaluate(guard, at);
  return w.empty() ? aig_.make_input() : w[0];
}

void SymbolicCode::execute(StmtId body, const Variables& variables, Signal condition, Signal& fault) {
  SymbolicPoint at{variables, condition, fault};
  AbstractInterpreter::execute(body, at);
}

void SymbolicCode::store(const Stmt& s, SymbolicPoint& at) {
  const Word value = evaluate(s.value, at);
  const bool is_self = s.op == StmtOp::StoreSelf;
  const Word before = is_self ? at.variables.self(s.index) : at.variables.bind(s.index);
  (is_self ? at.variables.set_self : at.variables.set_bind)(s.index, merged(at.condition, value, before, s.type));
}

void SymbolicCode::branch(const Stmt& s, SymbolicPoint& at) {
  const Signal holds = test(s.value, at.variables, at.condition, at.fault);
  execute(s.then_body, at.variables, aig_.make_and(at.condition, holds), at.fault);
  execute(s.else_body, at.variables, aig_.make_and(at.condition, negated(holds)), at.fault);
}

}  // namespace bip::verify
