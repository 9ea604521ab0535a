// Converts ranges, names, paths, strings, annotations, parameters and data declarations.
#include "compiler/parse/convert.hpp"
#include "compiler/parse/unescape.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {

using namespace syntax;

SourceRange Converter::range(const antlr4::Token* token) const {
  BIP_ASSERT(token->getStopIndex() <= text_.size(), "token ends at {} of {} bytes", token->getStopIndex(),
             text_.size());
  return {file_, static_cast<std::uint32_t>(token->getStartIndex()), static_cast<std::uint32_t>(token->getStopIndex())};
}

SourceRange Converter::range(const antlr4::ParserRuleContext* ctx) const {
  SourceRange r = range(ctx->start);
  // An empty rule stops before it starts.
  if (ctx->stop != nullptr && ctx->stop->getStopIndex() >= r.begin) {
    r.end = static_cast<std::uint32_t>(ctx->stop->getStopIndex());
  } else {
    r.end = r.begin;
  }
  BIP_ASSERT(r.begin <= r.end, "a rule ends at {} before it begins at {}", r.end, r.begin);
  return r;
}

SourceRange Converter::range(const antlr4::Token* first, const antlr4::ParserRuleContext* last) const {
  return {file_, range(first).begin, range(last).end};
}

Name Converter::name(const antlr4::Token* token) const { return {text(range(token)), range(token)}; }
Name Converter::name(BipParser::IdContext* ctx) const { return name(ctx->start); }

std::span<const Name> Converter::names(const std::vector<BipParser::IdContext*>& ids) {
  std::vector<Name> list;
  list.reserve(ids.size());
  for (BipParser::IdContext* id : ids) list.push_back(name(id));
  return arena_.list(list);
}

std::span<const Name> Converter::names(BipParser::IdListContext* ctx) {
  return ctx == nullptr ? std::span<const Name>() : names(ctx->id());
}

PathPart Converter::part(BipParser::PathPartContext* ctx) {
  PathPart p{.name = name(ctx->id())};
  if (BipParser::IndexContext* index = ctx->index()) {
    p.star = index->STAR() != nullptr;
    if (index->expr() != nullptr) p.index = value(index->expr());
  }
  return p;
}

Path Converter::path(BipParser::PathContext* ctx) {
  std::vector<PathPart> parts;
  for (BipParser::PathPartContext* p : ctx->pathPart()) parts.push_back(part(p));
  return {arena_.list(parts), range(ctx)};
}

Path Converter::path(BipParser::PortPathContext* ctx) {
  std::vector<PathPart> parts;
  for (BipParser::PortPartContext* p : ctx->portPart()) {
    PathPart to{.name = name(p->id())};
    to.star = p->STAR() != nullptr;
    if (p->expr() != nullptr) to.index = value(p->expr());
    parts.push_back(to);
  }
  return {arena_.list(parts), range(ctx)};
}

// The elements of an array, all of them: `c[*]`.
Path Converter::path(BipParser::FamilyContext* ctx) {
  const Name first = name(ctx->id(0));
  const std::string_view low = text(range(ctx->SUBSCRIPT(0)->getSymbol()));
  const std::string_view high = text(range(ctx->SUBSCRIPT(1)->getSymbol()));
  if (first.text != name(ctx->id(1)).text || low != "\u2081" || high != "\u2099") {
    diags_.report(Diag::kB2051, range(ctx), text(range(ctx)))
        .help(fmt::format("write `{0}\u2081, \u2026, {0}\u2099`, or `{0}[*]`", first.text), range(ctx),
              fmt::format("{}[*]", first.text));
  }
  return {arena_.list(std::vector<PathPart>{{.name = first, .star = true}}), range(ctx)};
}

TypeRef Converter::type_ref(BipParser::TypeNameContext* ctx, Constness constness) {
  TypeRef type;
  type.is_const = constness == Constness::Const;
  if (ctx == nullptr) return type;
  if (ctx->path() != nullptr) {
    type.name = path(ctx->path());
    for (const PathPart& p : type.name.parts) {
      if (p.index != nullptr || p.star) diags_.report(Diag::kB0019, type.name.range, "a type has no index");
    }
  } else {
    type.name = {arena_.list(std::vector<PathPart>{{.name = name(ctx->start)}}), range(ctx)};
  }
  return type;
}

std::string_view Converter::string(antlr4::tree::TerminalNode* node) {
  const SourceRange at = range(node->getSymbol());
  std::string plain;
  const std::string_view body = string_body(text(at));
  const auto offset = static_cast<std::uint32_t>(body.data() - text_.data());
  for (const BadEscape& bad : unescape(body, plain)) {
    const SourceRange where{file_, offset + bad.begin, offset + bad.end};
    diags_.report(Diag::kB0005, where, text(where)).help("a backslash itself is written `\\\\`");
  }
  return plain == body ? body : arena_.text(plain);
}

Annotations Converter::annotations(const std::vector<BipParser::AnnotationContext*>& list) {
  std::vector<Annotation> out;
  for (BipParser::AnnotationContext* ctx : list) {
    if (failed(ctx)) continue;
    std::vector<AnnotationArg> args;
    for (BipParser::AnnotationArgContext* a : ctx->annotationArg()) {
      AnnotationArg arg{.key = a->id(0) != nullptr ? name(a->id(0)) : name(a->start), .value = {}};
      if (a->STRING() != nullptr) {
        arg.value = string(a->STRING());
      } else if (a->ASSIGN() != nullptr) {
        arg.value = text(range(a->stop));
      }
      args.push_back(arg);
    }
    out.push_back({.name = name(ctx->id()), .args = arena_.list(args), .range = range(ctx)});
  }
  return arena_.list(out);
}

std::span<const Param> Converter::params(BipParser::ParamsContext* ctx) {
  std::vector<Param> list;
  if (ctx == nullptr) return {};
  for (BipParser::ParamContext* p : ctx->param()) {
    list.push_back({.type = type_ref(p->typeName(), constness(p->CONST())), .name = name(p->id())});
  }
  return arena_.list(list);
}

std::span<const Var> Converter::vars(const std::vector<BipParser::VarContext*>& list) {
  std::vector<Var> out;
  for (BipParser::VarContext* v : list) {
    out.push_back({.name = name(v->id()), .init = v->expr() == nullptr ? nullptr : value(v->expr())});
  }
  return arena_.list(out);
}

DataDecl Converter::data(BipParser::DataDeclContext* ctx, Annotations annotations) {
  return {.annotations = annotations,
          .type = type_ref(ctx->typeName(), constness(ctx->CONST())),
          .exported = ctx->EXPORT() != nullptr,
          .vars = vars(ctx->var()),
          .range = range(ctx)};
}

}  // namespace bip::parse
