// The paths that guards and actions name, as written. Linear; recursion follows the nesting of the source, which the
// parser limits.
#pragma once
#include <span>

#include "compiler/syntax/syntax.hpp"

namespace bip::syntax {

/// Returns the path that the statement itself assigns, or nullptr: branches, and what a call changes by reference, do
/// not count.
[[nodiscard]] inline const Path* assigned_path(const Stmt& s) {
  return parts_of(s) == StmtParts::Target ? &s.target : nullptr;
}

/// Calls `see(const Path&)` for every path that the expression reads, in the order of the text; nullptr has none.
template <class See>
void for_each_path(const Expr* e, const See& see) {
  if (e == nullptr) return;
  if (e->kind == ExprKind::Path) see(e->path);
  for (const Expr* operand : e->operands) for_each_path(operand, see);
}

/// Calls `see(const Path&)` for every path that the statements read or assign: a target before its value.
template <class See>
void for_each_path(std::span<const Stmt* const> stmts, const See& see) {
  for (const Stmt* s : stmts) {
    if (const Path* target = assigned_path(*s)) see(*target);
    for_each_path(s->value, see);
    for_each_path(s->then_body, see);
    for_each_path(s->else_body, see);
  }
}

/// Calls `see(const Path&)` for every path in the code of the clause.
template <class See>
void for_each_path(const Clause& c, const See& see) {
  for_each_path(c.guard, see);
  for (const Block* block : {&c.up, &c.down, &c.action}) for_each_path(block->stmts, see);
}

}  // namespace bip::syntax
