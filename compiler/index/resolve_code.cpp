// Uses in expressions, actions and paths. Depth is that of the tree, which the parser limits.
#include "compiler/index/index_builder.hpp"
#include "compiler/syntax/code_paths.hpp"

namespace bip::index {

using namespace syntax;

SymbolId IndexBuilder::find_in_scope(std::string_view name, const Scope& scope) const {
  for (auto loop = scope.loop_variables.rbegin(); loop != scope.loop_variables.rend(); ++loop) {
    if (out_.symbols[*loop].name == name) return *loop;
  }
  for (const SymbolId owner : scope.owners) {
    if (const SymbolId found = find(owner, name); found.is_valid()) return found;
  }
  return find_in_files(name, scope.file);
}

SymbolId IndexBuilder::path(const Path& p, const Scope& scope, UseKind last) {
  for (const PathPart& part : p.parts) expr(part.index, scope);
  if (p.parts.empty()) return {};
  SymbolId found = find_in_scope(p.parts.front().name.text, scope);
  // `std.ports.kLimit`: a package's name is in no scope.
  if (!found.is_valid()) return p.parts.size() > 1 ? use_type(p, scope.file) : SymbolId();
  use(p.parts.front().name.range, found, p.parts.size() == 1 ? last : UseKind::Read);
  for (std::size_t i = 1; i < p.parts.size() && found.is_valid(); ++i) {
    found = member(found, p.parts[i].name.text);
    use(p.parts[i].name.range, found, i + 1 == p.parts.size() ? last : UseKind::Read);
  }
  return found;
}

void IndexBuilder::expr(const Expr* e, const Scope& scope) {
  if (e == nullptr) return;
  if (e->kind == ExprKind::Path) path(e->path, scope, UseKind::Read);
  if (e->kind == ExprKind::Call) {
    // A function is one of a package, whatever the names around are.
    for (const PathPart& part : e->path.parts) expr(part.index, scope);
    use_type(e->path, scope.file);
  }
  for (const Expr* operand : e->operands) expr(operand, scope);
}

void IndexBuilder::stmts(std::span<const Stmt* const> list, const Scope& scope) {
  for (const Stmt* s : list) {
    if (const Path* target = syntax::assigned_path(*s)) path(*target, scope, UseKind::Write);
    expr(s->value, scope);
    stmts(s->then_body, scope);
    stmts(s->else_body, scope);
  }
}

}  // namespace bip::index
