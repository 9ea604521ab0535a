// The order of the type passes, and what they share: type names, port types, constants, functions.
#include <algorithm>

#include "compiler/model/builder.hpp"

namespace bip::model {

using syntax::DeclKind;

bool NameSpace::declare(const syntax::Name& name, const char* what) {
  const auto [it, is_new] = taken_.try_emplace(std::string(name.text), name.range, what);
  if (is_new) return true;
  diags_.report(Diag::kB1002, name.range, name.text, owner_)
      .label(fmt::format("this {} has the same name", what))
      .label(it->second.first, fmt::format("{} declared here", it->second.second));
  return false;
}

std::vector<std::string> NameSpace::names() const {
  std::vector<std::string> all;
  for (const auto& [name, where] : taken_) all.push_back(name);
  return all;
}

bool is_suppressed(syntax::Annotations annotations, std::string_view name) {
  for (const syntax::Annotation& a : annotations) {
    if (a.name.text != "SuppressWarning") continue;
    for (const syntax::AnnotationArg& arg : a.args) {
      if (arg.key.text == name) return true;
    }
  }
  return false;
}

std::string quoted_list(std::vector<std::string> names) {
  constexpr std::size_t kShown = 5;
  std::sort(names.begin(), names.end());
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) text += fmt::format("{}`{}`", i == 0 ? "" : ", ", names[i]);
  return names.size() > kShown ? text + " and others" : text;
}

void help_similar(DiagnosticBuilder d, std::string_view wrong, SourceRange at, std::vector<std::string> known) {
  std::sort(known.begin(), known.end());
  for (const std::string& name : similar_names(wrong, known)) d.help(fmt::format("`{}` has a similar name", name), at, name);
}

std::optional<std::uint32_t> Builder::type_row(const syntax::TypeRef& type, TypeName::Kind kind, const char* what) {
  std::string name = text(type.name);
  if (const std::string prefix = model.package + "."; name.starts_with(prefix)) name.erase(0, prefix.size());
  const auto it = model.type_names.find(name);
  if (it == model.type_names.end()) {
    std::vector<std::string> known;
    for (const auto& [key, row] : model.type_names) {
      if (row.kind == kind) known.push_back(key);
    }
    help_similar(diags.report(Diag::kB1006, type.name.range, what, name), name, type.name.range, known);
    return std::nullopt;
  }
  if (it->second.kind != kind) {
    static constexpr const char* kKinds[] = {"a port type", "a connector type", "an atom type", "a compound type"};
    diags.report(Diag::kB1007, type.name.range, name, kKinds[static_cast<int>(it->second.kind)], what).label(it->second.range, "declared here");
    return std::nullopt;
  }
  return it->second.row;
}

PortTypeId Builder::port_type(const syntax::TypeRef& type) {
  const auto row = type_row(type, TypeName::Kind::Port, "port type");
  return row ? PortTypeId(*row) : PortTypeId{};
}

SourceRange Builder::declared(const std::string& type) const {
  const auto it = model.type_names.find(type);
  return it == model.type_names.end() ? SourceRange{} : it->second.range;
}

PortTypeId Builder::anonymous_port_type(const std::vector<Variable>& variables) {
  std::string key;
  for (const Variable& v : variables) key += fmt::format("{} {},", name_of(v.type), v.name);
  const auto [it, is_new] = model.anonymous_port_types.try_emplace(key);
  if (is_new) it->second = model.port_types.push({fmt::format("?{}", model.anonymous_port_types.size()), variables, {}});
  return it->second;
}

bool fits(const Model& model, PortTypeId given, PortTypeId wanted) {
  if (!given.is_valid() || !wanted.is_valid() || given == wanted) return true;
  const PortType& a = model.port_types[given];
  const PortType& b = model.port_types[wanted];
  if (!a.name.starts_with('?') && !b.name.starts_with('?')) return false;
  return std::equal(a.variables.begin(), a.variables.end(), b.variables.begin(), b.variables.end(),
                    [](const Variable& x, const Variable& y) { return x.type == y.type; });
}

std::string port_type_text(const Model& model, PortTypeId type) {
  const PortType& t = model.port_types[type];
  if (!t.name.starts_with('?')) return fmt::format("of port type `{}`", t.name);
  if (t.variables.empty()) return "a port without data";
  std::string text;
  for (const Variable& v : t.variables) text += fmt::format("{}`{} {}`", text.empty() ? "a port with " : ", ", name_of(v.type), v.name);
  return text;
}

void build_port_types(Builder& b) {
  for (const syntax::Decl* decl : b.model.syntax->package->decls) {
    if (decl->kind != DeclKind::PortType) continue;
    PortType type{.name = std::string(decl->name.text), .variables = {}, .loc = b.loc(decl->name.range)};
    NameSpace names(b.diags, fmt::format("port type `{}`", decl->name.text));
    for (const syntax::Param& p : decl->params) {
      names.declare(p.name, "variable");
      type.variables.push_back({std::string(p.name.text), require_native_type(p.type, b.sources, b.diags), b.loc(p.name.range)});
    }
    b.model.port_types.push(std::move(type));
  }
}

namespace {

// Rows are given in declaration order, kind by kind, before anything is built: names may be used before their declaration.
void declare_names(Builder& b) {
  NameSpace types(b.diags, fmt::format("package `{}`", b.model.package));
  NameSpace values(b.diags, fmt::format("package `{}`", b.model.package));
  NameSpace functions(b.diags, fmt::format("package `{}`", b.model.package));
  std::uint32_t rows[4] = {};
  for (const syntax::Decl* decl : b.model.syntax->package->decls) {
    TypeName::Kind kind{};
    switch (decl->kind) {
      case DeclKind::PortType: kind = TypeName::Kind::Port; break;
      case DeclKind::ConnectorType: kind = TypeName::Kind::Connector; break;
      case DeclKind::AtomType: kind = TypeName::Kind::Atom; break;
      case DeclKind::CompoundType: kind = TypeName::Kind::Compound; break;
      case DeclKind::Function:
        if (!functions.declare(decl->name, "function")) continue;
        [[fallthrough]];
      case DeclKind::ExternFunction: b.model.functions[std::string(decl->name.text)] = decl; continue;
      case DeclKind::ExternType: b.not_yet(decl->range, "`extern data type`"); continue;
      case DeclKind::ExternOperator: b.not_yet(decl->range, "`extern operator`"); continue;
      case DeclKind::ConstData:
        for (const syntax::DataDecl& d : decl->data) {
          for (const syntax::Var& v : d.vars) values.declare(v.name, "constant");
        }
        continue;
    }
    const std::uint32_t row = rows[static_cast<int>(kind)]++;
    if (types.declare(decl->name, "type")) b.model.type_names[std::string(decl->name.text)] = {kind, row, decl->name.range};
  }
  for (const syntax::Path& use : b.model.syntax->package->uses) b.not_yet(use.range, "`use` of another package");
}

void build_constants(Builder& b) {
  const Scope scope{.names = {}, .owner = fmt::format("package `{}`", b.model.package)};
  for (const syntax::Decl* decl : b.model.syntax->package->decls) {
    if (decl->kind != DeclKind::ConstData) continue;
    for (const syntax::DataDecl& d : decl->data) {
      const Type type = require_native_type(d.type, b.sources, b.diags);
      for (const syntax::Var& v : d.vars) {
        CodeBuilder code(b.model, b.diags, scope);
        if (v.init == nullptr) b.diags.report(Diag::kB1008, v.name.range, v.name.text);
        const ExprId value = v.init == nullptr ? code.poison(type) : code.expr_as(v.init, type, fmt::format("constant `{}`", v.name.text));
        b.model.constants[std::string(v.name.text)] = {value, type};
      }
    }
  }
}

// A function is checked by calling it with default values.
void check_functions(Builder& b) {
  for (const syntax::Decl* decl : b.model.syntax->package->decls) {
    if (decl->kind != DeclKind::Function) continue;
    Scope scope{.names = {}, .owner = fmt::format("function `{}`", decl->name.text)};
    const Scope empty;
    CodeBuilder outer(b.model, b.diags, empty);
    NameSpace names(b.diags, scope.owner);
    for (const syntax::Param& p : decl->params) {
      names.declare(p.name, "parameter");
      const Type type = require_native_type(p.type, b.sources, b.diags);
      scope.names[std::string(p.name.text)] = {.type = type, .read_only = "a parameter keeps its value", .value = outer.poison(type), .declared = p.name.range};
    }
    CodeBuilder code(b.model, b.diags, scope, *decl);
    code.expr_as(decl->body, require_native_type(decl->result, b.sources, b.diags), "the function's result");
  }
}

// component lines of the paper's notation that give initial values to data by name
void collect_initialised_data(Builder& b, std::span<const syntax::CompoundItem* const> items) {
  for (const syntax::CompoundItem* item : items) {
    collect_initialised_data(b, item->items);
    for (const syntax::NamedArg& arg : item->args) {
      if (!arg.name.text.empty()) b.initialised_data[b.text(item->type.name)].insert(std::string(arg.name.text));
    }
  }
}

}  // namespace

std::optional<Model> build_model(const syntax::Syntax& syntax, const SourceMap& sources, Diagnostics& diags) {
  Model model;
  model.sources = &sources;
  model.syntax = &syntax;
  for (std::size_t i = 0; i < sources.size(); ++i) model.files.push_back(sources.name(FileId(i)));
  model.code.string("");
  if (syntax.package == nullptr) return std::nullopt;
  Builder b{model, diags, sources, {}};
  model.package = syntax.package->name.parts.empty() ? "" : b.text(syntax.package->name);
  declare_names(b);
  build_constants(b);
  check_functions(b);
  for (const syntax::Decl* decl : syntax.package->decls) collect_initialised_data(b, decl->items);
  build_port_types(b);
  build_atom_types(b);
  build_connector_types(b);
  build_compound_types(b);
  if (diags.has_errors()) return std::nullopt;
  return model;
}

}  // namespace bip::model
