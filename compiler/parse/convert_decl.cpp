// Converts a file and its declarations, and checks declarations as a whole: misplaced and missing parts.
#include <algorithm>
#include <utility>

#include "compiler/parse/convert.hpp"

namespace bip::parse {

using namespace syntax;

const Package* Converter::file(BipParser::FileContext* ctx) {
  Package package;
  std::vector<const Decl*> decls;
  std::vector<Path> uses;
  BipParser::PackageContext* first = nullptr;
  bool told_outside = false;
  const auto add = [&](BipParser::DeclContext* d) {
    if (failed(d)) return;
    if (const Decl* made = decl(d)) decls.push_back(made);
  };
  for (antlr4::tree::ParseTree* child : ctx->children) {
    if (auto* d = dynamic_cast<BipParser::DeclContext*>(child)) {
      if (first != nullptr && !failed(first) && !std::exchange(told_outside, true)) {
        diags_.report(Diag::kB0018, range(d->start), "a declaration", text(package.name.range))
            .label(range(first->stop), "the package ends here")
            .help("a file holds one package; its `end` comes last");
      }
      add(d);
    }
    auto* p = dynamic_cast<BipParser::PackageContext*>(child);
    if (p == nullptr) continue;
    if (first != nullptr) {
      if (!failed(first->path()))
        diags_.report(Diag::kB0017, range(p->start))
            .label(range(first->start), "the first one")
            .help("one package a file");
      continue;
    }
    first = p;
    if (!failed(p->path())) package.name = path(p->path());
    package.annotations = annotations(p->annotation());
    for (BipParser::UseContext* use : p->use()) {
      if (!failed(use) && !failed(use->path())) uses.push_back(path(use->path()));
    }
    for (BipParser::DeclContext* d : p->decl()) add(d);
  }
  package.uses = arena_.list(uses);
  package.decls = arena_.list(decls);
  package.range = {file_, 0, static_cast<std::uint32_t>(text_.size())};
  return arena_.make(package);
}

std::span<const Param> Converter::proto_params(const std::vector<BipParser::ProtoParamContext*>& list) {
  std::vector<Param> out;
  for (BipParser::ProtoParamContext* p : list) {
    Param param{.type = type_ref(p->typeName(), constness(p->CONST())), .name = {}};
    if (p->id() != nullptr) param.name = name(p->id());
    out.push_back(param);
  }
  return arena_.list(out);
}

const Decl* Converter::decl(BipParser::DeclContext* ctx) {
  Decl d;
  d.annotations = annotations(ctx->annotation());
  d.range = range(ctx);
  declaration_ = d.range;
  if (BipParser::ConstDataContext* c = ctx->constData()) {
    if (failed(c)) return nullptr;
    d.kind = DeclKind::ConstData;
    DataDecl data{.annotations = {},
                  .type = type_ref(c->typeName(), Constness::Const),
                  .vars = vars(c->var()),
                  .range = range(c)};
    d.name = data.vars.empty() ? Name{} : data.vars.front().name;
    d.data = arena_.list(std::vector<DataDecl>{data});
  } else if (BipParser::FunctionDeclContext* f = ctx->functionDecl()) {
    if (failed(f)) return nullptr;
    d.kind = DeclKind::Function;
    d.name = name(f->id());
    d.result = type_ref(f->typeName(), Constness::Mutable);
    d.params = params(f->params());
    d.body = value(f->expr());
    if (d.body == nullptr) return nullptr;
  } else if (BipParser::PortTypeContext* p = ctx->portType()) {
    if (failed(p)) return nullptr;
    d.kind = DeclKind::PortType;
    d.name = name(p->id());
    d.params = params(p->params());
  } else if (BipParser::ConnectorTypeContext* n = ctx->connectorType()) {
    if (failed(n)) return nullptr;
    d.kind = DeclKind::ConnectorType;
    d.name = name(n->id());
    d.params = params(n->params());
    owner_ = {"connector type `" + std::string(d.name.text) + "`", d.kind, Notation::Bip2, false};
    d.connector = connector_body(n->connectorPart());
    if (d.connector->define == nullptr && !is_broken(d.range)) missing_define(d);
  } else if (BipParser::AtomTypeContext* a = ctx->atomType()) {
    if (failed(a)) return nullptr;
    d.kind = DeclKind::AtomType;
    d.name = name(a->id());
    d.params = params(a->params());
    d = body_decl(d, "atom type", a->bodyItem());
  } else if (BipParser::CompoundTypeContext* k = ctx->compoundType()) {
    if (failed(k)) return nullptr;
    d.kind = DeclKind::CompoundType;
    d.name = name(k->id());
    d.params = params(k->params());
    d = body_decl(d, "compound type", k->bodyItem());
  } else if (BipParser::ComponentContext* m = ctx->component()) {
    if (failed(m)) return nullptr;
    d.notation = Notation::Paper;
    d.name = name(m->id());
    d.params = params(m->params());
    // The behavior makes a component an atom: known only after a look at its items.
    d.kind = DeclKind::CompoundType;
    for (BipParser::BodyItemContext* item : m->bodyItem()) {
      if (item->behavior() != nullptr || item->initial() != nullptr || item->finals() != nullptr ||
          item->transition() != nullptr || item->places() != nullptr) {
        d.kind = DeclKind::AtomType;
      }
    }
    d = body_decl(d, "component", m->bodyItem());
  } else {
    const Decl outside = extern_decl(ctx);
    return outside.name.text.empty() ? nullptr : arena_.make(outside);
  }
  return arena_.make(d);
}

Decl Converter::extern_decl(BipParser::DeclContext* ctx) {
  Decl d;
  d.annotations = annotations(ctx->annotation());
  d.range = range(ctx);
  if (BipParser::ExternTypeContext* t = ctx->externType(); t != nullptr && !failed(t)) {
    d.kind = DeclKind::ExternType;
    d.name = t->id() != nullptr ? name(t->id()) : name(t->NATIVE()->getSymbol());
    std::vector<Path> refines;
    for (BipParser::TypeNameContext* r : t->typeName()) refines.push_back(type_ref(r, Constness::Mutable).name);
    d.refines = arena_.list(refines);
    if (t->STRING() != nullptr) d.cpp_name = string(t->STRING());
  } else if (BipParser::ExternFunctionContext* f = ctx->externFunction(); f != nullptr && !failed(f)) {
    d.kind = DeclKind::ExternFunction;
    d.name = name(f->id());
    d.result = type_ref(f->typeName(), constness(f->CONST()));
    d.params = proto_params(f->protoParam());
  } else if (BipParser::ExternOperatorContext* o = ctx->externOperator(); o != nullptr && !failed(o)) {
    d.kind = DeclKind::ExternOperator;
    d.op = name(o->operatorSign()->start);
    d.name = d.op;
    d.result = type_ref(o->typeName(), constness(o->CONST()));
    d.params = proto_params(o->protoParam());
  }
  return d;
}

bool Converter::is_broken(SourceRange declaration) {
  if (!has_broken_) {
    has_broken_ = true;
    for (const Diagnostic* d : diags_.sorted()) {
      if (d->severity == Severity::Error && d->range.file == file_) broken_.push_back(d->range.begin);
    }
  }
  const auto first = std::lower_bound(broken_.begin(), broken_.end(), declaration.begin);
  return first != broken_.end() && *first <= declaration.end;
}

void Converter::misplaced(std::string_view what, SourceRange at) {
  if (is_broken(declaration_) || misplaced_ == std::pair(declaration_.begin, what)) return;
  misplaced_ = {declaration_.begin, what};
  diags_.report(Diag::kB0016, at, what, owner_.phrase)
      .note(owner_.kind == DeclKind::AtomType
                ? "an atom has data, ports, places and transitions; components and connectors are in compounds"
                : "a compound has components and connectors; data, places and transitions are in atoms");
}

Decl Converter::body_decl(Decl d, std::string_view what, const std::vector<BipParser::BodyItemContext*>& list) {
  open_body(d, what);
  Items items;
  for (BipParser::BodyItemContext* item : list) {
    if (!failed(item)) body_item(item, items);
  }
  close_body(d, items);
  return d;
}

void Converter::open_body(const Decl& d, std::string_view what) {
  owner_ = {std::string(what) + " `" + std::string(d.name.text) + "`", d.kind, d.notation, false};
}

void Converter::close_body(Decl& d, const Items& items) {
  check_body(d, items);
  d.data = arena_.list(items.data);
  d.ports = arena_.list(items.ports);
  d.clocks = arena_.list(items.clocks);
  d.places = arena_.list(items.places);
  d.initial = items.initial;
  d.transitions = arena_.list(items.transitions);
  d.atom_priorities = arena_.list(items.atom_priorities);
  d.finals = arena_.list(items.finals);
  d.invariants = arena_.list(items.invariants);
  d.items = arena_.list(items.items);
  d.priorities = arena_.list(items.priorities);
  d.exports = arena_.list(items.exports);
}

std::string Converter::line_like(std::uint32_t offset) const {
  const std::size_t begin = text_.rfind('\n', offset) + 1;  // the first line: npos + 1 = 0
  const std::size_t end = std::min(text_.find_first_not_of(" \t", begin), text_.size());
  return "\n" + std::string(text_.substr(begin, end - begin));
}

void Converter::missing_define(const Decl& d) {
  auto diagnostic = diags_.report(Diag::kB0014, d.name.range, owner_.phrase, "`define`")
                        .note("`define` says which ports take part together");
  if (d.params.empty()) return;
  std::string line = "define";
  for (const Param& p : d.params) line.append(" ").append(p.name.text);
  const std::size_t header = text_.find(')', d.params.back().name.range.end) + 1;
  const auto at = static_cast<std::uint32_t>(header);
  diagnostic.help("all together: `" + line + "`", {file_, at, at}, line_like(d.range.begin) + "  " + line);
}

void Converter::missing_places(const Decl& d, const Items& items) {
  const bool is_paper = d.notation == Notation::Paper;
  auto diagnostic = diags_.report(Diag::kB0014, d.name.range, owner_.phrase, is_paper ? "state" : "`place` line");
  std::vector<std::string_view> used;
  const auto use = [&](std::span<const Name> names) {
    for (const Name& n : names) {
      if (std::find(used.begin(), used.end(), n.text) == used.end()) used.push_back(n.text);
    }
  };
  use(items.initial.to);
  for (const Transition& t : items.transitions) {
    use(t.from);
    use(t.to);
  }
  if (is_paper || used.empty()) {
    diagnostic.help(is_paper ? "a behavior has at least one `state NAME`"
                             : "an atom has at least one place: `place NAME`");
    return;
  }
  std::string line = "place ";
  for (const std::string_view name : used) line.append(line.size() > 6 ? ", " : "").append(name);
  std::uint32_t before = items.initial.present ? items.initial.range.begin : items.transitions.front().range.begin;
  for (const Transition& t : items.transitions) before = std::min(before, t.range.begin);
  diagnostic.help("write `" + line + "`", {file_, before, before}, line + line_like(before));
}

void Converter::missing_initial(const Decl& d, const Items& items) {
  const Name& last = items.places.back();
  const std::string line = "initial to " + std::string(items.places.front().text);
  auto diagnostic = diags_.report(Diag::kB0014, d.name.range, owner_.phrase, "`initial`");
  if (d.notation == Notation::Paper || items.has_behavior) {
    diagnostic.help("say where it begins: `behavior " + line + "`");
    return;
  }
  diagnostic.help("say where it begins: `" + line + "`", {file_, last.range.end, last.range.end},
                  line_like(last.range.begin) + line);
}

void Converter::check_body(const Decl& d, const Items& items) {
  if (diags_.has_errors()) return;
  if (d.kind == DeclKind::AtomType) {
    if (items.places.empty()) {
      missing_places(d, items);
    } else if (!items.initial.present) {
      missing_initial(d, items);
    }
  } else if (items.items.empty()) {
    diags_.report(Diag::kB0014, d.name.range, owner_.phrase,
                  d.notation == Notation::Paper ? "behavior and no `contains`" : "component");
  }
}

}  // namespace bip::parse
