// Converts the contents of compounds: components, connectors (typed and inline), `for`, priorities, exports.
#include "compiler/parse/convert.hpp"

namespace bip::parse {

using namespace syntax;

/// True if the item is one of a compound (or was reported as misplaced in an atom).
bool Converter::compound_item(BipParser::BodyItemContext* ctx, Annotations marks, Items& to) {
  const bool in_compound = owner_.kind == DeclKind::CompoundType;
  const bool belongs = ctx->contains() != nullptr || ctx->componentDecl() != nullptr ||
                       ctx->connectorDecl() != nullptr || ctx->inlineConnector() != nullptr ||
                       ctx->forItems() != nullptr || ctx->compoundExport() != nullptr || ctx->propertyDecl() != nullptr;
  if (belongs && !in_compound) {
    std::string_view what = "an export of a part's port or data";
    if (ctx->contains() != nullptr || ctx->componentDecl() != nullptr) what = "a component";
    if (ctx->connectorDecl() != nullptr || ctx->inlineConnector() != nullptr) what = "a connector";
    if (ctx->forItems() != nullptr) what = "a `for`";
    if (ctx->propertyDecl() != nullptr) what = "a property";
    misplaced(what, range(ctx));
    return true;
  }
  if (!in_compound) return false;
  if (BipParser::ContainsContext* c = ctx->contains()) {
    instances(c->instance(), c->path(), range(c), marks, to);
  } else if (BipParser::ComponentDeclContext* d = ctx->componentDecl()) {
    instances(d->instance(), d->path(), range(d), marks, to);
  } else if (ctx->connectorDecl() != nullptr) {
    bindings(ctx->connectorDecl(), marks, to);
  } else if (ctx->inlineConnector() != nullptr) {
    inline_connector(ctx->inlineConnector(), marks, to);
  } else if (ctx->forItems() != nullptr) {
    for_items(ctx->forItems(), marks, to);
  } else if (ctx->propertyDecl() != nullptr) {
    property(ctx->propertyDecl(), marks, to);
    if (const CompoundItem* made = to.items.back(); made->index != nullptr) {
      diags_.report(Diag::kB3020, made->index->range, "property", made->name.text)
          .help("only in a `for` are there several of one name");
    }
  } else if (ctx->priority() != nullptr) {
    to.priorities.push_back(compound_priority(ctx->priority(), marks));
    if (const CompoundPriority& made = to.priorities.back(); made.index != nullptr) {
      diags_.report(Diag::kB3020, made.index->range, "priority", made.name.text)
          .help("only in a `for` are there several of one name");
    }
  } else if (BipParser::CompoundExportContext* e = ctx->compoundExport()) {
    CompoundExport made{
        .annotations = marks, .is_data = e->DATA() != nullptr, .name = name(e->id()), .range = range(e)};
    std::vector<Path> targets;
    for (BipParser::PathContext* p : e->path()) targets.push_back(path(p));
    made.targets = arena_.list(targets);
    to.exports.push_back(made);
  } else if (BipParser::PortDeclContext* p = ctx->portDecl();
             p != nullptr && p->EXPORT() != nullptr && p->typeName() == nullptr && p->id() != nullptr) {
    // `export port tick as t` without a dot reads as an atom's port in the grammar.
    CompoundExport made{.annotations = marks, .name = name(p->id()), .range = range(p)};
    std::vector<Path> targets;
    for (BipParser::PortItemContext* item : p->portItem()) {
      const Name n = name(item->id());
      targets.push_back({arena_.list(std::vector<PathPart>{{.name = n}}), n.range});
    }
    made.targets = arena_.list(targets);
    to.exports.push_back(made);
  } else {
    return false;
  }
  return true;
}

void Converter::instances(const std::vector<BipParser::InstanceContext*>& list, BipParser::PathContext* type,
                          SourceRange at, Annotations marks, Items& to) {
  const TypeRef ref{.name = path(type)};
  for (BipParser::InstanceContext* i : list) {
    CompoundItem item{.kind = ItemKind::Component, .annotations = marks, .range = list.size() == 1 ? at : range(i)};
    item.name = name(i->id());
    item.type = ref;
    if (i->index() != nullptr) {
      item.index = value(i->index()->expr());
      if (i->index()->STAR() != nullptr)
        diags_.report(Diag::kB0019, range(i->index()), "a component's `[ ]` holds a size or an index, not `*`");
    }
    item.args = named_args(i->args());
    to.items.push_back(arena_.make(item));
  }
}

void Converter::bound_ports(BipParser::BoundPortsContext* ctx, std::vector<Path>& to) {
  if (ctx == nullptr) return;
  for (BipParser::BoundPortContext* p : ctx->boundPort()) {
    if (p->path() != nullptr) {
      to.push_back(path(p->path()));
    } else if (p->family() != nullptr) {
      to.push_back(path(p->family()));
    } else {
      bound_ports(p->boundPorts(), to);
    }
  }
}

void Converter::bindings(BipParser::ConnectorDeclContext* ctx, Annotations marks, Items& to) {
  const TypeRef ref{.name = path(ctx->path())};
  for (BipParser::BindingContext* b : ctx->binding()) {
    CompoundItem item{
        .kind = ItemKind::Connector, .annotations = marks, .range = ctx->binding().size() == 1 ? range(ctx) : range(b)};
    item.name = name(b->id());
    item.type = ref;
    if (b->index() != nullptr) {
      item.index = value(b->index()->expr());
      if (b->index()->STAR() != nullptr)
        diags_.report(Diag::kB0019, range(b->index()), "a connector's `[ ]` holds a size or an index, not `*`");
    }
    std::vector<Path> ports;
    bound_ports(b->boundPorts(), ports);
    item.ports = arena_.list(ports);
    to.items.push_back(arena_.make(item));
  }
}

void Converter::inline_connector(BipParser::InlineConnectorContext* ctx, Annotations marks, Items& to) {
  CompoundItem item{.kind = ItemKind::Connector, .annotations = marks, .range = range(ctx)};
  BipParser::BindingContext* b = ctx->binding();
  item.name = name(b->id());
  if (b->index() != nullptr) item.index = value(b->index()->expr());
  std::vector<Path> ports;
  bound_ports(b->boundPorts(), ports);
  item.ports = arena_.list(ports);
  const Owner outer = owner_;
  owner_.phrase = "connector `" + std::string(item.name.text) + "`";
  owner_.is_inline_connector = true;
  item.inline_body = connector_body(ctx->connectorPart());
  owner_ = outer;
  to.items.push_back(arena_.make(item));
}

void Converter::property(BipParser::PropertyDeclContext* ctx, Annotations marks, Items& to) {
  CompoundItem item{.kind = ItemKind::Property, .annotations = marks, .range = range(ctx)};
  item.name = name(ctx->id());
  if (ctx->index() != nullptr && ctx->index()->expr() != nullptr) item.index = value(ctx->index()->expr());
  if (ctx->index() != nullptr && ctx->index()->STAR() != nullptr)
    diags_.report(Diag::kB0019, range(ctx->index()), "a property's `[ ]` holds an index, not `*`");
  SourceRange inside = range(ctx->PROPERTY_TEXT()->getSymbol());
  ++inside.begin;
  --inside.end;
  item.property = {text(inside), inside};
  to.items.push_back(arena_.make(item));
}

void Converter::for_items(BipParser::ForItemsContext* ctx, Annotations marks, Items& to) {
  CompoundItem item{.kind = ItemKind::For, .annotations = marks, .range = range(ctx)};
  item.name = name(ctx->id());
  item.low = value(ctx->expr(0));
  item.high = value(ctx->expr(1));
  Items inner;
  for (BipParser::BodyItemContext* i : ctx->bodyItem()) {
    if (failed(i)) continue;
    const bool repeats = i->contains() != nullptr || i->componentDecl() != nullptr || i->connectorDecl() != nullptr ||
                         i->inlineConnector() != nullptr || i->forItems() != nullptr;
    if (i->propertyDecl() != nullptr) {
      property(i->propertyDecl(), annotations(i->annotation()), inner);
    } else if (repeats) {
      body_item(i, inner);
    } else if (i->priority() != nullptr) {
      CompoundItem rule{
          .kind = ItemKind::Priority, .annotations = annotations(i->annotation()), .range = range(i->priority())};
      rule.priority = arena_.make(compound_priority(i->priority(), rule.annotations));
      rule.name = rule.priority->name;
      rule.index = rule.priority->index;
      inner.items.push_back(arena_.make(rule));
    } else {
      diags_.report(Diag::kB0019, range(i),
                    "a `for` repeats components, connectors, priorities, properties and other `for`s only");
    }
  }
  item.items = arena_.list(inner.items);
  if (item.low != nullptr && item.high != nullptr) to.items.push_back(arena_.make(item));
}

InteractionPattern Converter::pattern(BipParser::PrioritySideContext* ctx) {
  InteractionPattern p{.range = range(ctx)};
  if (ctx->path().empty()) {
    p.any_connector = true;
    p.any_interaction = true;
    return p;
  }
  p.connector = path(ctx->path(0));
  std::vector<Path> ports;
  for (std::size_t i = 1; i < ctx->path().size(); ++i) ports.push_back(path(ctx->path(i)));
  p.ports = arena_.list(ports);
  p.any_interaction = ports.empty();
  return p;
}

CompoundPriority Converter::compound_priority(BipParser::PriorityContext* ctx, Annotations marks) {
  CompoundPriority made{.annotations = marks,
                        .name = name(ctx->id()),
                        .index = nullptr,
                        .low = pattern(ctx->prioritySide(0)),
                        .high = pattern(ctx->prioritySide(1))};
  if (ctx->provided() != nullptr) made.guard = guard(ctx->provided());
  if (ctx->index() != nullptr && ctx->index()->expr() != nullptr) made.index = value(ctx->index()->expr());
  if (ctx->index() != nullptr && ctx->index()->STAR() != nullptr)
    diags_.report(Diag::kB0019, range(ctx->index()), "a priority's `[ ]` holds an index, not `*`");
  made.range = range(ctx);
  return made;
}

}  // namespace bip::parse
