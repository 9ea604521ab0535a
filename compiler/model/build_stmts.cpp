// Typed statements: assignments and `if`, chained by `next`. Part of CodeBuilder (code_builder.hpp).
#include "compiler/model/code_builder.hpp"

namespace bip::model {

StmtId CodeBuilder::store_self(std::uint32_t slot, Type type, ExprId value, Loc at, StmtId next) {
  return model_.code.stmts.push({.op = StmtOp::StoreSelf, .type = type, .index = slot, .value = value, .then_body = {}, .else_body = {}, .next = next, .loc = at});
}

// Built back to front, so that each statement knows the next.
StmtId CodeBuilder::block(std::span<const syntax::Stmt* const> stmts, StmtId tail) {
  StmtId next = tail;
  for (std::size_t i = stmts.size(); i-- > 0;) next = statement(stmts[i], next);
  return next;
}

StmtId CodeBuilder::statement(const syntax::Stmt* s, StmtId next) {
  switch (s->kind) {
    case syntax::StmtKind::Call:
      if (expr(s->value)) diags_.report(Diag::kB1017, s->range);
      return next;
    case syntax::StmtKind::If: {
      const ExprId condition = expr_as(s->value, Type::Bool, "the condition");
      const StmtId then_body = block(s->then_body);
      const StmtId else_body = block(s->else_body);
      return model_.code.stmts.push({.op = StmtOp::If, .type = Type::Bool, .value = condition, .then_body = then_body, .else_body = else_body, .next = next, .loc = loc(s->range)});
    }
    case syntax::StmtKind::Assign: break;
  }
  const std::string name = path_key(s->target, *model_.sources);
  if (find(s->target, false) == nullptr && model_.constants.contains(name)) {
    diags_.report(Diag::kB1018, s->target.range, name, "a constant keeps its value");
    return next;
  }
  const Binding* target = find(s->target, true);
  if (target == nullptr || target->poison) {
    expr(s->value);
    return next;
  }
  if (!target->read_only.empty() || target->value.is_valid()) {
    auto d = diags_.report(Diag::kB1018, s->target.range, name, target->read_only);
    if (target->declared.is_valid()) d.label(target->declared, "declared here");
    return next;
  }
  const ExprId value = expr_as(s->value, target->type, fmt::format("`{}`", name));
  return model_.code.stmts.push({.op = target->load == Op::LoadSelf ? StmtOp::StoreSelf : StmtOp::StoreBind,
                                 .type = target->type, .index = target->index, .value = value, .then_body = {}, .else_body = {}, .next = next, .loc = loc(s->range)});
}

}  // namespace bip::model
