// The reference executor. One evaluator over the code IR executes guards, actions and transfers.
//
// Operands are evaluated left to right, && and || stop early, and the first fault ends the unit: nothing is read or
// stored after it. Statements are followed in a loop; expressions and nested ifs recurse, and the parser limits their
// depth. Float operations are plain IEEE double: this file is compiled without fast-math or contraction.
#include "compiler/interp/interp.hpp"

#include <vector>

#include "compiler/model/fold.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/arith.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::interp {

/// What a code unit's function gets as its context.
struct UnitContext {
  lower::LoweredSystem* lowered;
  ExprId expr;
  StmtId body;
};

namespace {

rt::Cell int_cell(std::int32_t value) {
  rt::Cell variable{};
  variable.bits = static_cast<std::uint32_t>(value);
  return variable;
}
rt::Cell bool_cell(bool value) { return int_cell(value ? 1 : 0); }
rt::Cell float_cell(double value) {
  rt::Cell variable{};
  variable.f = value;
  return variable;
}

class Evaluator {
 public:
  Evaluator(lower::LoweredSystem& lowered, rt::Cell* self, rt::Cell* all, const std::uint32_t* bind)
      : code_(lowered.system->code), lowered_(lowered), self_(self), all_(all), bind_(bind) {}

  /// The value; meaningless once status() is not 0.
  rt::Cell eval(ExprId id);
  void execute(StmtId first);
  /// 0, or the status of the first fault.
  [[nodiscard]] std::int32_t status() const { return status_; }

 private:
  rt::Cell unary(const Expr& e, rt::Cell a);
  rt::Cell arithmetic(ExprId id, const Expr& e);
  rt::Cell comparison(const Expr& e);
  rt::Cell short_circuit(const Expr& e);
  rt::Cell call(ExprId id, const Expr& e);
  void store(Type type, rt::Cell& to, rt::Cell value);

  const CodeTable& code_;
  lower::LoweredSystem& lowered_;
  rt::Cell* self_;
  rt::Cell* all_;
  const std::uint32_t* bind_;
  std::int32_t status_ = 0;
};

rt::Cell Evaluator::eval(ExprId id) {
  const Expr& e = code_.exprs[id];
  switch (e.op) {
    case Op::ConstInt:
    case Op::ConstBool:
    case Op::ConstString: return int_cell(e.int_value);
    case Op::ConstFloat: return float_cell(e.float_value);
    case Op::LoadSelf: return self_[e.index];
    case Op::LoadBind: return all_[bind_[e.index]];
    case Op::Call: return call(id, e);
    case Op::And:
    case Op::Or: return short_circuit(e);
    case Op::IntToFloat:
    case Op::Neg:
    case Op::Not:
    case Op::BitNot: {
      const rt::Cell a = eval(e.a);
      return status_ != 0 ? a : unary(e, a);
    }
      BIP_VALUE_OPS(BIP_OP_CASE) return arithmetic(id, e);
      BIP_COMPARISON_OPS(BIP_OP_CASE) return comparison(e);
  }
  BIP_UNREACHABLE("not an operator of an expression");
}

rt::Cell Evaluator::unary(const Expr& e, rt::Cell a) {
  if (e.op == Op::IntToFloat) return float_cell(static_cast<double>(a.i));
  return e.type == Type::Float ? float_cell(-a.f) : int_cell(fold_int(e.op, a.i));
}

rt::Cell Evaluator::short_circuit(const Expr& e) {
  const rt::Cell a = eval(e.a);
  const bool decided = e.op == Op::And ? a.i == 0 : a.i != 0;
  return status_ != 0 || decided ? a : eval(e.b);
}

rt::Cell Evaluator::arithmetic(ExprId id, const Expr& e) {
  const rt::Cell a = eval(e.a);
  if (status_ != 0) return a;
  const rt::Cell b = eval(e.b);
  if (status_ != 0) return b;
  if (e.type == Type::Float) return float_cell(fold_float(e.op, a.f, b.f));
  if (is_division(e.op)) {
    status_ = rt::division_status(a.i, b.i, lowered_.site_of_expr[id.value]);
    if (status_ != 0) return int_cell(0);
  }
  return int_cell(fold_int(e.op, a.i, b.i));
}

rt::Cell Evaluator::comparison(const Expr& e) {
  const rt::Cell a = eval(e.a);
  if (status_ != 0) return a;
  const rt::Cell b = eval(e.b);
  if (status_ != 0) return b;
  if (code_.exprs[e.a].type == Type::Float) return bool_cell(fold_comparison(e.op, a.f, b.f));
  return bool_cell(fold_comparison(e.op, a.i, b.i));
}

// Arguments by value are evaluated, from left to right, into variables of their own; the others are the variables'
// variables.
rt::Cell Evaluator::call(ExprId id, const Expr& e) {
  const Function& function = code_.functions[e.index];
  const std::span<const ExprId> args = code_.args_of(e);
  BIP_ASSERT(args.size() == function.params.size() && lowered_.functions[e.index] != nullptr, "{} arguments for `{}`",
             args.size(), function.name);
  std::vector<rt::Cell> values(args.size());
  std::vector<rt::Cell*> variables;
  for (std::size_t k = 0; k < args.size(); ++k) {
    const Expr& arg = code_.exprs[args[k]];
    if (function.params[k].by_reference) {
      variables.push_back(arg.op == Op::LoadSelf ? self_ + arg.index : all_ + bind_[arg.index]);
      continue;
    }
    values[k] = eval(args[k]);
    if (status_ != 0) return values[k];
    variables.push_back(&values[k]);
  }
  rt::Cell result{};
  if (function.has_result && is_ffi(function.result))
    result = *lowered_.results.cell(id.value, lowered_.ffi_types[ffi_row(function.result)]);
  const std::uint32_t site = lowered_.site_of_expr[id.value];
  rt::Cell where = int_cell(static_cast<std::int32_t>(site));
  variables.push_back(&where);
  if (lowered_.functions[e.index](&lowered_.ffi, &result, variables.data()) != 0) {
    status_ = rt::fault_status(site, rt::FaultKind{});
  }
  return result;
}

// FFI types: the object is copied, the variable keeps its own.
void Evaluator::store(Type type, rt::Cell& to, rt::Cell value) {
  if (is_ffi(type)) {
    lowered_.ffi_types[ffi_row(type)].copy(&rt::object_in<char>(to), &rt::object_in<char>(value));
  } else {
    to = value;
  }
}

void Evaluator::execute(StmtId first) {
  for (StmtId id = first; id.is_valid(); id = code_.stmts[id].next) {
    const Stmt& stmt = code_.stmts[id];
    const rt::Cell value = eval(stmt.value);
    if (status_ != 0) return;
    switch (stmt.op) {
      case StmtOp::StoreSelf: store(stmt.type, self_[stmt.index], value); break;
      case StmtOp::StoreBind: store(stmt.type, all_[bind_[stmt.index]], value); break;
      case StmtOp::Call: break;
      case StmtOp::If:
        execute(value.i != 0 ? stmt.then_body : stmt.else_body);
        if (status_ != 0) return;
        break;
    }
  }
}

std::int32_t run_guard(const void* context, rt::Cell* self, rt::Cell* all, const std::uint32_t* bind) {
  const auto& c = *static_cast<const UnitContext*>(context);
  Evaluator evaluator(*c.lowered, self, all, bind);
  const rt::Cell value = evaluator.eval(c.expr);
  BIP_ASSERT(evaluator.status() != 0 || value.i == 0 || value.i == 1, "a guard returns {}", value.i);
  return evaluator.status() != 0 ? evaluator.status() : value.i;
}

std::int32_t run_action(const void* context, rt::Cell* self, rt::Cell* all, const std::uint32_t* bind) {
  const auto& c = *static_cast<const UnitContext*>(context);
  Evaluator evaluator(*c.lowered, self, all, bind);
  evaluator.execute(c.body);
  return evaluator.status() != 0 ? evaluator.status() : 1;
}

}  // namespace

struct Interpreter::Impl {
  std::vector<UnitContext> contexts;  // one a unit
};

Interpreter::Interpreter(lower::LoweredSystem& lowered) : impl_(std::make_unique<Impl>()) {
  impl_->contexts.reserve(lowered.units.size());
  BIP_ASSERT(lowered.codes.size() == lowered.units.size(), "{} codes of {} units", lowered.codes.size(),
             lowered.units.size());
  std::size_t row = 0;
  for (const lower::CodeUnit& unit : lowered.units) {
    impl_->contexts.push_back({&lowered, unit.expr, unit.body});
    const bool is_guard = unit.kind == lower::CodeKind::Guard;
    lowered.codes[row++] = {is_guard ? &run_guard : &run_action, &impl_->contexts.back()};
  }
}

Interpreter::~Interpreter() = default;

}  // namespace bip::interp
