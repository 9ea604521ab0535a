// See abstract_code.hpp. Recursion follows the code's trees, whose depth the parser and .bsys reader bound.
#include "compiler/verify/net/abstract_code.hpp"

#include <limits>

namespace bip::verify {

namespace {

std::int32_t wrapped(std::uint32_t bits) { return static_cast<std::int32_t>(bits); }

AbstractValue arithmetic(Op op, std::int32_t a, std::int32_t b) {
  const auto ua = static_cast<std::uint32_t>(a);
  const auto ub = static_cast<std::uint32_t>(b);
  switch (op) {
    case Op::Add: return known(wrapped(ua + ub));
    case Op::Sub: return known(wrapped(ua - ub));
    case Op::Mul: return known(wrapped(ua * ub));
    case Op::Div:
    case Op::Mod:
      if (b == 0 || (a == std::numeric_limits<std::int32_t>::min() && b == -1)) return {};
      return known(op == Op::Div ? a / b : a % b);
    case Op::BitAnd: return known(wrapped(ua & ub));
    case Op::BitOr: return known(wrapped(ua | ub));
    case Op::BitXor: return known(wrapped(ua ^ ub));
    case Op::Eq: return known(a == b ? 1 : 0);
    case Op::Ne: return known(a != b ? 1 : 0);
    case Op::Lt: return known(a < b ? 1 : 0);
    case Op::Gt: return known(a > b ? 1 : 0);
    case Op::Le: return known(a <= b ? 1 : 0);
    case Op::Ge: return known(a >= b ? 1 : 0);
    default: return {};
  }
}

AbstractValue at(std::span<const AbstractValue> values, std::uint32_t index) {
  return index < values.size() ? values[index] : AbstractValue{};
}

}  // namespace

AbstractValue evaluate(const CodeTable& code, ExprId id, std::span<const AbstractValue> self,
                       std::span<const AbstractValue> bind) {
  if (!id.is_valid()) return {};
  const Expr& e = code.exprs[id];
  switch (e.op) {
    case Op::ConstInt:
    case Op::ConstBool:
    case Op::ConstString: return known(e.int_value);
    case Op::LoadSelf: return at(self, e.index);
    case Op::LoadBind: return at(bind, e.index);
    case Op::And:
    case Op::Or: {
      const AbstractValue a = evaluate(code, e.a, self, bind);
      const AbstractValue b = evaluate(code, e.b, self, bind);
      const std::int32_t decides = e.op == Op::Or ? 1 : 0;
      if (a.is_known && a.value == decides) return a;
      // A fault on the left ends the run: what matters is what holds if it goes on.
      if (b.is_known && b.value == decides) return b;
      return a.is_known && b.is_known ? known(1 - decides) : AbstractValue{};
    }
    case Op::Neg:
    case Op::Not:
    case Op::BitNot: {
      const AbstractValue a = evaluate(code, e.a, self, bind);
      if (!a.is_known || e.type == Type::Float) return {};
      if (e.op == Op::Not) return known(a.value == 0 ? 1 : 0);
      const auto bits = static_cast<std::uint32_t>(a.value);
      return known(wrapped(e.op == Op::Neg ? 0u - bits : ~bits));
    }
    case Op::Add:
    case Op::Sub:
    case Op::Mul:
    case Op::Div:
    case Op::Mod:
    case Op::BitAnd:
    case Op::BitOr:
    case Op::BitXor:
    case Op::Eq:
    case Op::Ne:
    case Op::Lt:
    case Op::Gt:
    case Op::Le:
    case Op::Ge: {
      const Type operands = code.exprs[e.a].type;
      if (operands != Type::Int && operands != Type::Bool && operands != Type::String) return {};
      const AbstractValue a = evaluate(code, e.a, self, bind);
      const AbstractValue b = evaluate(code, e.b, self, bind);
      return a.is_known && b.is_known ? arithmetic(e.op, a.value, b.value) : AbstractValue{};
    }
    default: return {};
  }
}

void execute(const CodeTable& code, StmtId body, std::vector<AbstractValue>& self) {
  std::vector<AbstractValue> bind;
  execute(code, body, self, bind);
}

void execute(const CodeTable& code, StmtId body, std::vector<AbstractValue>& self, std::vector<AbstractValue>& bind) {
  for (StmtId id = body; id.is_valid(); id = code.stmts[id].next) {
    const Stmt& s = code.stmts[id];
    if (s.op == StmtOp::StoreSelf || s.op == StmtOp::StoreBind) {
      const bool is_exact = s.type == Type::Int || s.type == Type::Bool || s.type == Type::String;
      std::vector<AbstractValue>& values = s.op == StmtOp::StoreSelf ? self : bind;
      if (s.index < values.size()) values[s.index] = is_exact ? evaluate(code, s.value, self, bind) : AbstractValue{};
    } else if (s.op == StmtOp::If) {
      const AbstractValue condition = evaluate(code, s.value, self, bind);
      if (condition.is_known) {
        execute(code, condition.value != 0 ? s.then_body : s.else_body, self, bind);
        continue;
      }
      std::vector<AbstractValue> other = self, other_bind = bind;
      execute(code, s.then_body, self, bind);
      execute(code, s.else_body, other, other_bind);
      for (std::size_t k = 0; k < self.size(); ++k) {
        if (self[k] != other[k]) self[k] = {};
      }
      for (std::size_t k = 0; k < bind.size(); ++k) {
        if (bind[k] != other_bind[k]) bind[k] = {};
      }
    }
  }
}

bool is_always_true(const CodeTable& code, ExprId guard) {
  if (!guard.is_valid()) return true;
  const AbstractValue value = evaluate(code, guard, {}, {});
  return value.is_known && value.value != 0;
}

}  // namespace bip::verify
