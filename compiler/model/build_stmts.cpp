// Typed statements: assignments and `if`, chained by `next`. Part of CodeBuilder (code_builder.hpp).
#include "compiler/model/ffi_declarations.hpp"
#include "compiler/model/packages.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

StmtId CodeBuilder::store_self(std::uint32_t variable, Type type, ExprId value, Loc at, StmtId next) {
  return model_.code.stmts.push({.op = StmtOp::StoreSelf,
                                 .type = type,
                                 .index = variable,
                                 .value = value,
                                 .then_body = {},
                                 .else_body = {},
                                 .next = next,
                                 .loc = at});
}

// Built back to front, so that each statement knows the next.
StmtId CodeBuilder::block(std::span<const syntax::Stmt* const> stmts, StmtId tail) {
  const bool before = in_block_, drew = may_draw_;
  in_block_ = may_draw_ = true;
  StmtId next = tail;
  for (std::size_t i = stmts.size(); i-- > 0;) next = statement(stmts[i], next);
  in_block_ = before;
  may_draw_ = drew;
  return next;
}

StmtId CodeBuilder::statement(const syntax::Stmt* s, StmtId next) {
  switch (s->kind) {
    case syntax::StmtKind::Call: {
      is_statement_ = true;
      const std::optional<Typed> call = expr(s->value);
      is_statement_ = false;
      if (!call) return next;
      if (model_.code.exprs[call->id].op != Op::Call) {
        diags_.report(Diag::kB1017, s->range);
        return next;
      }
      return model_.code.stmts.push({.op = StmtOp::Call,
                                     .type = call->type,
                                     .value = call->id,
                                     .then_body = {},
                                     .else_body = {},
                                     .next = next,
                                     .loc = loc(s->range)});
    }
    case syntax::StmtKind::If: {
      const ExprId condition = expr_as(s->value, Type::Bool, "the condition");
      const StmtId then_body = block(s->then_body);
      const StmtId else_body = block(s->else_body);
      return model_.code.stmts.push({.op = StmtOp::If,
                                     .type = Type::Bool,
                                     .value = condition,
                                     .then_body = then_body,
                                     .else_body = else_body,
                                     .next = next,
                                     .loc = loc(s->range)});
    }
    case syntax::StmtKind::Assign: return assignment(s, next);
  }
  BIP_UNREACHABLE("statement");
}

StmtId CodeBuilder::assignment(const syntax::Stmt* s, StmtId next) {
  const std::string name = path_key(s->target, *model_.sources);
  if (find(s->target, Lookup::Silent) == nullptr &&
      !visible_keys(model_, model_.constants, name, s->target.range.file).empty()) {
    diags_.report(Diag::kB1018, s->target.range, name, "a constant keeps its value");
    return next;
  }
  const Binding* target = find(s->target, Lookup::Reported);
  if (target == nullptr || target->poison) {
    expr(s->value);
    return next;
  }
  if (s->clock_speed || target->is_clock) return clock_statement(s, *target, next);
  if (!target->read_only.empty() || target->value.is_valid()) {
    auto d = diags_.report(Diag::kB1018, s->target.range, name, target->read_only);
    if (target->declared.is_valid()) d.label(target->declared, "declared here");
    return next;
  }
  if (const auto assign = model_.operators.find("operator =");
      assign != model_.operators.end() && is_ffi(target->type)) {
    const std::optional<Argument> given = argument(s->value);
    if (!given) return next;
    const ExprId load = make({.op = target->load,
                              .type = target->type,
                              .index = target->index,
                              .a = {},
                              .b = {},
                              .loc = loc(s->target.range)});
    const std::vector<Argument> args{{{load, target->type}, true, false, s->target.range}, *given};
    if (!best_prototypes(model_, assign->second, args).empty()) {
      const std::optional<Typed> call = ffi_call("=", assign->second, args, s->range, CallUse::Statement);
      if (!call) return next;
      return model_.code.stmts.push({.op = StmtOp::Call,
                                     .type = call->type,
                                     .value = call->id,
                                     .then_body = {},
                                     .else_body = {},
                                     .next = next,
                                     .loc = loc(s->range)});
    }
  }
  const ExprId value = expr_as(s->value, target->type, fmt::format("`{}`", name));
  return model_.code.stmts.push({.op = target->load == Op::LoadSelf ? StmtOp::StoreSelf : StmtOp::StoreBind,
                                 .type = target->type,
                                 .index = target->index,
                                 .value = value,
                                 .then_body = {},
                                 .else_body = {},
                                 .next = next,
                                 .loc = loc(s->range)});
}

}  // namespace bip::model
