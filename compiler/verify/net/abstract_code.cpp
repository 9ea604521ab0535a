// See abstract_code.hpp. Recursion follows the code's trees, whose depth the parser and .bsys reader bound.
#include "compiler/verify/net/abstract_code.hpp"

#include "compiler/model/abstract_interpreter.hpp"
#include "compiler/model/fold.hpp"

namespace bip::verify {

namespace {

bool is_exact(Type type) { return type == Type::Int || type == Type::Bool || type == Type::String; }

struct ConstantPoint {
  std::span<const AbstractValue> self, bind;
};
struct ConstantState {
  std::vector<AbstractValue>& self;
  std::vector<AbstractValue>& bind;
};

/// The domain of constants: one value that is known, or any.
class ConstantDomain : public AbstractInterpreter<ConstantDomain, AbstractValue, ConstantPoint, ConstantState> {
 public:
  using AbstractInterpreter::AbstractInterpreter;

  AbstractValue constant(const Expr& e) { return e.op == Op::ConstFloat ? AbstractValue{} : known(e.int_value); }
  AbstractValue load(const Expr& e, const ConstantPoint& point) {
    const std::span<const AbstractValue> values = e.op == Op::LoadSelf ? point.self : point.bind;
    return e.index < values.size() ? values[e.index] : AbstractValue{};
  }
  AbstractValue call(const Expr&, ConstantPoint&) { return {}; }
  AbstractValue unary(const Expr& e, const AbstractValue& a, ConstantPoint&) {
    if (!a.is_known || e.type == Type::Float) return {};
    return known(fold_int(e.op, a.value));
  }
  AbstractValue logic(const Expr& e, ConstantPoint& point) {
    const AbstractValue a = evaluate(e.a, point), b = evaluate(e.b, point);
    const std::int32_t decides = e.op == Op::Or ? 1 : 0;
    if (a.is_known && a.value == decides) return a;
    // A fault on the left ends the run: what matters is what holds if it goes on.
    if (b.is_known && b.value == decides) return b;
    return a.is_known && b.is_known ? known(1 - decides) : AbstractValue{};
  }
  AbstractValue binary(const Expr& e, const AbstractValue& a, const AbstractValue& b, ConstantPoint&) {
    if (!is_exact(code_.exprs[e.a].type) || !a.is_known || !b.is_known) return {};
    if (is_division(e.op) && division_faults(a.value, b.value)) return {};
    return known(fold_int(e.op, a.value, b.value));
  }

  bool goes_on(const ConstantState&) { return true; }
  void store(const Stmt& s, ConstantState& state) {
    std::vector<AbstractValue>& values = s.op == StmtOp::StoreSelf ? state.self : state.bind;
    if (s.index < values.size()) values[s.index] = is_exact(s.type) ? value_of(s, state) : AbstractValue{};
  }
  void branch(const Stmt& s, ConstantState& state) {
    const AbstractValue condition = value_of(s, state);
    if (condition.is_known) return execute(condition.value != 0 ? s.then_body : s.else_body, state);
    std::vector<AbstractValue> self = state.self, bind = state.bind;
    ConstantState other{self, bind};
    execute(s.then_body, state);
    execute(s.else_body, other);
    join(state.self, self);
    join(state.bind, bind);
  }
  void run_call(const Stmt&, ConstantState&) {}

 private:
  AbstractValue value_of(const Stmt& s, const ConstantState& state) {
    ConstantPoint point{state.self, state.bind};
    return evaluate(s.value, point);
  }
  static void join(std::vector<AbstractValue>& to, const std::vector<AbstractValue>& from) {
    for (std::size_t k = 0; k < to.size(); ++k) {
      if (to[k] != from[k]) to[k] = {};
    }
  }
};

}  // namespace

AbstractValue evaluate(const CodeTable& code, ExprId id, std::span<const AbstractValue> self,
                       std::span<const AbstractValue> bind) {
  if (!id.is_valid()) return {};
  ConstantPoint point{self, bind};
  return ConstantDomain(code).evaluate(id, point);
}

void execute(const CodeTable& code, StmtId body, std::vector<AbstractValue>& self) {
  std::vector<AbstractValue> bind;
  execute(code, body, self, bind);
}

void execute(const CodeTable& code, StmtId body, std::vector<AbstractValue>& self, std::vector<AbstractValue>& bind) {
  ConstantState state{self, bind};
  ConstantDomain(code).execute(body, state);
}

bool is_always_true(const CodeTable& code, ExprId guard) {
  if (!guard.is_valid()) return true;
  const AbstractValue value = evaluate(code, guard, {}, {});
  return value.is_known && value.value != 0;
}

}  // namespace bip::verify
