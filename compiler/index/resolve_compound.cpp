// Uses in connectors (types and inline ones), in the items of compounds and in their priorities.
#include "compiler/index/index_builder.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::index {

using namespace syntax;

void IndexBuilder::port_expr(const PortExpr& e, const Scope& scope) {
  if (e.kind == PortExprKind::Port) path(e.port, scope, UseKind::Read);
  for (const PortExpr* child : e.children) port_expr(*child, scope);
}

void IndexBuilder::resolve_connector(const ConnectorBody& body, SymbolId /*owner*/, const Scope& scope) {
  for (const DataDecl& d : body.data) {
    for (const Var& v : d.vars) expr(v.init, scope);
  }
  if (body.define != nullptr) port_expr(*body.define, scope);
  for (const Clause& c : body.clauses) {
    for (const Path& p : c.ports) path(p, scope, UseKind::Read);
    expr(c.guard, scope);
    block(c.up, scope);
    block(c.down, scope);
    block(c.action, scope);
  }
}

void IndexBuilder::resolve_items(std::span<const CompoundItem* const> items, SymbolId owner, Scope& scope) {
  for (const CompoundItem* item : items) {
    if (item->kind == ItemKind::For) {
      expr(item->low, scope);
      expr(item->high, scope);
      scope.loop_variables.push_back(loops_.at(item));
      resolve_items(item->items, owner, scope);
      BIP_ASSERT(scope.loop_variables.back() == loops_.at(item), "a loop's variable is left in scope");
      scope.loop_variables.pop_back();
      continue;
    }
    expr(item->index, scope);
    if (item->kind == ItemKind::Property) continue;
    if (item->kind == ItemKind::Priority) {
      resolve_pattern(item->priority->low, scope);
      resolve_pattern(item->priority->high, scope);
      expr(item->priority->guard, scope);
      continue;
    }
    const SymbolId symbol = find(owner, item->name.text);
    for (const NamedArg& arg : item->args) {
      if (!arg.name.text.empty() && symbol.is_valid() && out_.symbols[symbol].type.is_valid())
        use_member(out_.symbols[symbol].type, arg.name);
      expr(arg.value, scope);
    }
    for (const Path& p : item->ports) path(p, scope, UseKind::Read);
    if (item->inline_body == nullptr || !symbol.is_valid()) continue;
    scope.owners.insert(scope.owners.begin(), symbol);
    resolve_connector(*item->inline_body, symbol, scope);
    BIP_ASSERT(scope.owners.front() == symbol, "a connector's scope was changed inside of it");
    scope.owners.erase(scope.owners.begin());
  }
}

void IndexBuilder::resolve_pattern(const InteractionPattern& p, const Scope& scope) {
  if (!p.any_connector) path(p.connector, scope, UseKind::Read);
  for (const Path& port : p.ports) path(port, scope, UseKind::Read);
}

}  // namespace bip::index
