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

Word SymbolicCode::call(const Expr& e, const Variables& variables, Signal condition, Signal& fault) {
  const Function& function = code_.functions[e.index];
  note(e.loc, "a call of `" + function.name + '`');
  const std::span<const ExprId> args = code_.args_of(e);
  for (std::size_t k = 0; k < args.size(); ++k) {
    const Expr& arg = code_.exprs[args[k]];
    if (!function.params[k].by_reference) {
      (void)evaluate(args[k], variables, condition, fault);
    } else if (arg.op == Op::LoadSelf && variables.set_self) {
      variables.set_self(arg.index, any(arg.type));
    } else if (arg.op == Op::LoadBind && variables.set_bind) {
      variables.set_bind(arg.index, any(arg.type));
    }
  }
  return any(e.type);
}

Word SymbolicCode::binary(const Expr& e, const Word& a, const Word& b, Signal condition, Signal& fault) {
  if (e.op == Op::Div || e.op == Op::Mod) {
    if (e.type != Type::Int) return {};
    if (a.empty() || b.empty()) {
      fault = aig_.make_or(fault, aig_.make_and(condition, aig_.make_input()));
      return any(Type::Int);
    }
    const Signal by_zero = equal(aig_, b, word_of(0));
    const Signal overflows =
        aig_.make_and(equal(aig_, a, word_of(std::numeric_limits<std::int32_t>::min())), equal(aig_, b, word_of(-1)));
    fault = aig_.make_or(fault, aig_.make_and(condition, aig_.make_or(by_zero, overflows)));
    const Division d = divide(aig_, a, b);
    return e.op == Op::Div ? d.quotient : d.remainder;
  }
  if (a.empty() || b.empty()) {
    if (e.type == Type::Bool) note(e.loc, "a comparison of values that are not followed");
    return any(e.type);
  }
  switch (e.op) {
    case Op::Add: return add(aig_, a, b);
    case Op::Sub: return subtract(aig_, a, b);
    case Op::Mul: return multiply(aig_, a, b);
    case Op::BitAnd: return bitwise_and(aig_, a, b);
    case Op::BitOr: return bitwise_or(aig_, a, b);
    case Op::BitXor: return bitwise_xor(aig_, a, b);
    case Op::Eq: return word_of_bool(equal(aig_, a, b));
    case Op::Ne: return word_of_bool(negated(equal(aig_, a, b)));
    case Op::Lt: return word_of_bool(less(aig_, a, b));
    case Op::Gt: return word_of_bool(less(aig_, b, a));
    case Op::Le: return word_of_bool(negated(less(aig_, b, a)));
    case Op::Ge: return word_of_bool(negated(less(aig_, a, b)));
    default: return any(e.type);
  }
}

Word SymbolicCode::evaluate(ExprId id, const Variables& variables, Signal condition, Signal& fault) {
  const Expr& e = code_.exprs[id];
  switch (e.op) {
    case Op::ConstInt:
    case Op::ConstString: return word_of(e.int_value);
    case Op::ConstBool: return word_of_bool(e.int_value != 0 ? kTrue : kFalse);
    case Op::ConstFloat: return {};
    case Op::LoadSelf: return variables.self(e.index);
    case Op::LoadBind: return variables.bind(e.index);
    case Op::Call: return call(e, variables, condition, fault);
    case Op::IntToFloat: (void)evaluate(e.a, variables, condition, fault); return {};
    case Op::And:
    case Op::Or: {
      Word a = evaluate(e.a, variables, condition, fault);
      if (a.empty()) a = any(Type::Bool);
      const Signal goes_on = e.op == Op::And ? a[0] : negated(a[0]);
      if (goes_on == kFalse) return a;
      Word b = evaluate(e.b, variables, aig_.make_and(condition, goes_on), fault);
      if (b.empty()) b = any(Type::Bool);
      return word_of_bool(e.op == Op::And ? aig_.make_and(a[0], b[0]) : aig_.make_or(a[0], b[0]));
    }
    case Op::Neg:
    case Op::Not:
    case Op::BitNot: {
      const Word a = evaluate(e.a, variables, condition, fault);
      if (a.empty()) return any(e.type);
      if (e.op == Op::Not) return word_of_bool(negated(a[0]));
      return e.op == Op::Neg ? negate(aig_, a) : complement(a);
    }
    default: {
      const Word a = evaluate(e.a, variables, condition, fault);
      const Word b = evaluate(e.b, variables, condition, fault);
      return binary(e, a, b, condition, fault);
    }
  }
}

Signal SymbolicCode::test(ExprId guard, const Variables& variables, Signal condition, Signal& fault) {
  if (!guard.is_valid()) return kTrue;
  const Word w = evaluate(guard, variables, condition, fault);
  return w.empty() ? aig_.make_input() : w[0];
}

void SymbolicCode::execute(StmtId body, const Variables& variables, Signal condition, Signal& fault) {
  if (condition == kFalse) return;
  for (StmtId id = body; id.is_valid(); id = code_.stmts[id].next) {
    const Stmt& s = code_.stmts[id];
    switch (s.op) {
      case StmtOp::StoreSelf: {
        const Word value = evaluate(s.value, variables, condition, fault);
        variables.set_self(s.index, merged(condition, value, variables.self(s.index), s.type));
        break;
      }
      case StmtOp::StoreBind: {
        const Word value = evaluate(s.value, variables, condition, fault);
        variables.set_bind(s.index, merged(condition, value, variables.bind(s.index), s.type));
        break;
      }
      case StmtOp::If: {
        const Signal holds = test(s.value, variables, condition, fault);
        execute(s.then_body, variables, aig_.make_and(condition, holds), fault);
        execute(s.else_body, variables, aig_.make_and(condition, negated(holds)), fault);
        break;
      }
      case StmtOp::Call: (void)evaluate(s.value, variables, condition, fault); break;
    }
  }
}

}  // namespace bip::verify
