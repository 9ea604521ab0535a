// Converts connector types and inline connectors: the define tree, clauses, the exported port.
#include "compiler/parse/convert.hpp"

namespace bip::parse {

using namespace syntax;

void Converter::repeated(std::string_view part, std::string_view whole, SourceRange at) {
  diags_.report(Diag::kB0013, at, part, whole);
}

const ConnectorBody* Converter::connector_body(const std::vector<BipParser::ConnectorPartContext*>& parts) {
  ConnectorBody body;
  std::vector<DataDecl> data_list;
  std::vector<Clause> clauses;
  for (BipParser::ConnectorPartContext* ctx : parts) {
    if (failed(ctx)) continue;
    const Annotations marks = annotations(ctx->annotation());
    if (ctx->dataDecl() != nullptr) {
      data_list.push_back(data(ctx->dataDecl(), marks));
    } else if (BipParser::ConnectorExportContext* e = ctx->connectorExport()) {
      if (body.exported.present) repeated("exported port", owner_.phrase, range(e));
      body.exported = {.present = true,
                       .annotations = marks,
                       .type = type_ref(e->typeName(), Constness::Mutable),
                       .name = name(e->id()),
                       .vars = names(e->idList()),
                       .range = range(e)};
    } else if (ctx->define() != nullptr) {
      if (body.define != nullptr) repeated("`define`", owner_.phrase, range(ctx->define()));
      body.define = define(ctx->define(), body.resume);
    } else if (ctx->clause() != nullptr) {
      clauses.push_back(clause(ctx->clause(), marks));
    }
  }
  body.data = arena_.list(data_list);
  body.clauses = arena_.list(clauses);
  return arena_.make(body);
}

const PortExpr* Converter::define(BipParser::DefineContext* ctx, Name& resume) {
  std::vector<const PortExpr*> children;
  for (BipParser::PortTermContext* term : ctx->portTerm()) children.push_back(port_term(term));
  // `define p q resume sync`: the last two read as ports in the grammar, since older models may name a port `resume`.
  const std::size_t n = children.size();
  const auto is_word = [&](std::size_t i, std::string_view word) {
    const PortExpr& e = *children[i];
    return e.kind == PortExprKind::Port && !e.trigger && e.port.parts.size() == 1 && e.port.parts[0].name.text == word;
  };
  if (n > 2 && is_word(n - 2, "resume") && (is_word(n - 1, "sync") || is_word(n - 1, "async"))) {
    resume = children[n - 1]->port.parts[0].name;
    children.resize(n - 2);
  }
  // One group around everything says nothing: `define (p q)` is `define p q`.
  const PortExpr* only =
      children.size() == 1 && children[0]->kind == PortExprKind::Group && !children[0]->trigger ? children[0] : nullptr;
  while (only != nullptr && only->children.size() == 1 && only->children[0]->kind == PortExprKind::Group &&
         !only->children[0]->trigger) {
    only = only->children[0];
  }
  if (only != nullptr) return only;
  PortExpr root{.kind = PortExprKind::Group, .children = arena_.list(children)};
  root.range = {file_, children.front()->range.begin, children.back()->range.end};
  return arena_.make(root);
}

const PortExpr* Converter::port_term(BipParser::PortTermContext* ctx) {
  PortExpr e{.kind = PortExprKind::Port, .trigger = ctx->PRIME() != nullptr, .range = range(ctx)};
  if (ctx->portPath() != nullptr) {
    e.port = path(ctx->portPath());
    return arena_.make(e);
  }
  if (ctx->family() != nullptr) {
    e.port = path(ctx->family());
    return arena_.make(e);
  }
  e.kind = PortExprKind::Group;
  std::vector<const PortExpr*> children;
  for (BipParser::PortTermContext* term : ctx->portTerm()) children.push_back(port_term(term));
  e.children = arena_.list(children);
  return arena_.make(e);
}

Clause Converter::clause(BipParser::ClauseContext* ctx, Annotations marks) {
  Clause c{.annotations = marks, .range = range(ctx)};
  std::vector<Path> ports;
  for (BipParser::ClausePortContext* p : ctx->clausePort())
    ports.push_back(p->family() != nullptr ? path(p->family()) : path(p->portPath()));
  c.ports = arena_.list(ports);
  constexpr std::string_view kWhole = "an `on` clause";
  for (std::size_t i = 1; i < ctx->provided().size(); ++i) repeated("`provided`", kWhole, range(ctx->provided(i)));
  for (std::size_t i = 1; i < ctx->up().size(); ++i) repeated("`up`", kWhole, range(ctx->up(i)));
  for (std::size_t i = 1; i < ctx->down().size(); ++i) repeated("`down`", kWhole, range(ctx->down(i)));
  for (std::size_t i = 1; i < ctx->action().size(); ++i) repeated("`do`", kWhole, range(ctx->action(i)));
  if (!ctx->provided().empty()) c.guard = guard(ctx->provided(0));
  if (!ctx->up().empty()) c.up = block(ctx->up(0)->block());
  if (!ctx->down().empty()) c.down = block(ctx->down(0)->block());
  if (!ctx->action().empty()) c.action = action(ctx->action(0));
  return c;
}

}  // namespace bip::parse
