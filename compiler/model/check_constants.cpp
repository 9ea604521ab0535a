// Warnings about what is written with literals alone: a guard that is never true, a division by zero. Part of
// CodeBuilder.
//
// Named constants are left out: a model may well be configured by them. Linear in the expression as it is written.
#include <algorithm>

#include "compiler/model/code_builder.hpp"
#include "compiler/model/evaluate.hpp"

namespace bip::model {

namespace {

bool has_only_literals(const syntax::Expr* e) {
  std::vector<const syntax::Expr*> todo{e};
  while (!todo.empty()) {
    e = todo.back();
    todo.pop_back();
    if (e->kind == syntax::ExprKind::Path || e->kind == syntax::ExprKind::Call) return false;
    todo.insert(todo.end(), e->operands.begin(), e->operands.end());
  }
  return true;
}

}  // namespace

void CodeBuilder::warn_never_true(const syntax::Expr* e, ExprId guard) {
  if (e->kind == syntax::ExprKind::Bool) return;  // a bare `false` is how one switches a clause off
  if (function_ != nullptr || diags_.has_errors() || !has_only_literals(e)) return;
  const Evaluated value = evaluate(model_.code, guard, {});
  if (value.fault == Fault::None && value.value.int_value == 0) diags_.report(Diag::kB1039, e->range);
}

void CodeBuilder::warn_zero_divisor(const syntax::Expr* e, Typed divisor) {
  if (divisor.type != Type::Int || diags_.has_errors() || !has_only_literals(e->operands[1])) return;
  const Evaluated value = evaluate(model_.code, divisor.id, {});
  if (value.fault == Fault::None && value.value.int_value == 0)
    diags_.report(Diag::kB1050, e->op_range, model_.sources->text(e->op_range))
        .label(e->operands[1]->range, "this is 0");
}

}  // namespace bip::model
