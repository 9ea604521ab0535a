// The order of the type passes, and what they share: type names, port types, constants, functions.
#include <algorithm>
#include <map>

#include "compiler/model/ffi_declarations.hpp"
#include "compiler/model/packages.hpp"

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
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i)
    text += fmt::format("{}`{}`", i == 0 ? "" : ", ", names[i]);
  return names.size() > kShown ? text + " and others" : text;
}

void help_similar(DiagnosticBuilder d, std::string_view wrong, SourceRange at, std::vector<std::string> known) {
  std::sort(known.begin(), known.end());
  for (const std::string& name : similar_names(wrong, known))
    d.help(fmt::format("`{}` has a similar name", name), at, name);
}

std::optional<std::uint32_t> ModelBuilder::type_row(const syntax::TypeRef& type, TypeName::Kind kind,
                                                    const char* what) {
  const std::string name = text(type.name);
  const TypeName* found = find_type(type.name);
  if (found == nullptr) {
    std::vector<std::string> known;
    for (const auto& [key, row] : model.type_names) {
      if (row.kind != kind) continue;
      if (std::string shown = shown_key(model, key, type.name.range.file); !shown.empty())
        known.push_back(std::move(shown));
    }
    help_similar(diags.report(Diag::kB1006, type.name.range, what, name), name, type.name.range, known);
    return std::nullopt;
  }
  if (found->kind != kind) {
    static constexpr const char* kKinds[] = {"a port type", "a connector type", "an atom type", "a compound type"};
    diags.report(Diag::kB1007, type.name.range, name, kKinds[static_cast<int>(found->kind)], what)
        .label(found->range, "declared here");
    return std::nullopt;
  }
  return found->row;
}

std::string ModelBuilder::key(const syntax::Decl& decl) const {
  return package_of(model, decl.name.range.file).prefix + std::string(decl.name.text);
}

const TypeName* ModelBuilder::find_type(const syntax::Path& path) {
  const bool is_plain = path.parts.size() == 1 && !path.parts.front().star && path.parts.front().index == nullptr;
  if (!is_plain) return find_visible(model, model.type_names, text(path), path.range, diags);
  auto& known = found_types[path.range.file.value];
  const std::string_view name = path.parts.front().name.text;
  if (const auto found = known.find(name); found != known.end()) return found->second;
  const std::size_t errors = diags.error_count();
  const TypeName* type = find_visible(model, model.type_names, text(path), path.range, diags);
  // What is missing, or has two meanings, is reported wherever it is written.
  if (type != nullptr && diags.error_count() == errors) known.emplace(name, type);
  return type;
}

SourceRange ModelBuilder::declared(const syntax::Path& type) {
  const TypeName* found = find_type(type);
  return found == nullptr ? SourceRange{} : found->range;
}

PortTypeId ModelBuilder::port_type(const syntax::TypeRef& type) {
  const auto row = type_row(type, TypeName::Kind::Port, "port type");
  return row ? PortTypeId(*row) : PortTypeId{};
}

SourceRange ModelBuilder::declared(const std::string& type) const {
  const auto it = model.type_names.find(type);
  return it == model.type_names.end() ? SourceRange{} : it->second.range;
}

PortTypeId ModelBuilder::anonymous_port_type(const std::vector<Variable>& variables) {
  std::string key;
  for (const Variable& v : variables) key += fmt::format("{} {},", model.code.type_name(v.type), v.name);
  const auto [it, is_new] = model.anonymous_port_types.try_emplace(key);
  if (is_new)
    it->second = model.port_types.push({fmt::format("?{}", model.anonymous_port_types.size()), variables, {}});
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
  for (const Variable& v : t.variables)
    text += fmt::format("{}`{} {}`", text.empty() ? "a port with " : ", ", model.code.type_name(v.type), v.name);
  return text;
}

void build_port_types(ModelBuilder& b) {
  for (const syntax::Decl* decl : b.model.decls) {
    if (decl->kind != DeclKind::PortType) continue;
    PortType type{.name = b.key(*decl), .variables = {}, .loc = b.loc(decl->name.range)};
    NameSpace names(b.diags, fmt::format("port type `{}`", decl->name.text));
    for (const syntax::Param& p : decl->params) {
      names.declare(p.name, "variable");
      type.variables.push_back(
          {std::string(p.name.text), data_type(b.model, p.type, b.diags), b.loc(p.name.range), p.type.is_const});
    }
    b.model.port_types.push(std::move(type));
  }
}

namespace {

// Rows are given in declaration order, kind by kind, before anything is built: names may be used before their
// declaration.
void declare_names(ModelBuilder& b) {
  struct Spaces {
    NameSpace types, values, functions;
  };
  std::map<std::uint32_t, Spaces> spaces;  // by file: one a package
  std::uint32_t rows[4] = {};
  for (const syntax::Decl* decl : b.model.decls) {
    const PackageScope& package = package_of(b.model, decl->name.range.file);
    const NameSpace empty(b.diags, fmt::format("package `{}`", package.name));
    auto& [types, values, functions] =
        spaces.try_emplace(package.file.value, Spaces{empty, empty, empty}).first->second;
    TypeName::Kind kind{};
    switch (decl->kind) {
      case DeclKind::PortType: kind = TypeName::Kind::Port; break;
      case DeclKind::ConnectorType: kind = TypeName::Kind::Connector; break;
      case DeclKind::AtomType: kind = TypeName::Kind::Atom; break;
      case DeclKind::CompoundType: kind = TypeName::Kind::Compound; break;
      case DeclKind::Function:
        if (!functions.declare(decl->name, "function")) continue;
        b.model.functions[b.key(*decl)] = decl;
        continue;
      case DeclKind::ExternType:
        if (syntax::is_native_type(decl->name.text)) {
          b.diags.report(Diag::kB1054, decl->name.range, decl->name.text)
              .help("remove the declaration; `bipc migrate` does");
        } else {
          (void)types.declare(decl->name, "type");
        }
        continue;
      case DeclKind::ExternFunction:
      case DeclKind::ExternOperator: continue;
      case DeclKind::ConstData:
        for (const syntax::DataDecl& d : decl->data) {
          for (const syntax::Var& v : d.vars) values.declare(v.name, "constant");
        }
        continue;
    }
    const std::uint32_t row = rows[static_cast<int>(kind)]++;
    if (types.declare(decl->name, "type")) b.model.type_names[b.key(*decl)] = {kind, row, decl->name.range};
  }
}

void build_constants(ModelBuilder& b) {
  for (const syntax::Decl* decl : b.model.decls) {
    if (decl->kind != DeclKind::ConstData) continue;
    const PackageScope& package = package_of(b.model, decl->range.file);
    const Scope scope{.names = {}, .owner = fmt::format("package `{}`", package.name)};
    for (const syntax::DataDecl& d : decl->data) {
      const Type type = native_data_type(b.model, d.type, "a constant", b.diags);
      for (const syntax::Var& v : d.vars) {
        CodeBuilder code(b.model, b.diags, scope);
        if (v.init == nullptr) b.diags.report(Diag::kB1008, v.name.range, v.name.text);
        ExprId value = v.init == nullptr ? code.poison(type)
                                         : code.expr_as(v.init, type, fmt::format("constant `{}`", v.name.text));
        if (calls_cpp(b.model.code, value)) b.diags.report(Diag::kB1045, v.init->range, v.name.text);
        value = code.folded(value);
        b.model.constants[package.prefix + std::string(v.name.text)] = {value, type};
      }
    }
  }
}

// A function is checked by calling it with default values.
void check_functions(ModelBuilder& b) {
  for (const syntax::Decl* decl : b.model.decls) {
    if (decl->kind != DeclKind::Function) continue;
    Scope scope{.names = {}, .owner = fmt::format("function `{}`", decl->name.text)};
    const Scope empty;
    CodeBuilder outer(b.model, b.diags, empty);
    NameSpace names(b.diags, scope.owner);
    for (const syntax::Param& p : decl->params) {
      names.declare(p.name, "parameter");
      const Type type = native_data_type(b.model, p.type, "a parameter of a function of BIP", b.diags);
      scope.names[std::string(p.name.text)] = {.type = type,
                                               .read_only = "a parameter keeps its value",
                                               .value = outer.poison(type),
                                               .declared = p.name.range};
    }
    CodeBuilder code(b.model, b.diags, scope, *decl);
    code.expr_as(decl->body, native_data_type(b.model, decl->result, "a result of a function of BIP", b.diags),
                 "the function's result");
  }
}

// component lines of the paper's notation that give initial values to data by name
void collect_initialised_data(ModelBuilder& b, std::span<const syntax::CompoundItem* const> items) {
  for (const syntax::CompoundItem* item : items) {
    collect_initialised_data(b, item->items);
    if (item->args.empty() || !item->type.is_written()) continue;
    const std::vector<std::string> keys =
        visible_keys(b.model, b.model.type_names, b.text(item->type.name), item->type.name.range.file);
    if (keys.empty()) continue;
    auto* collected = &b.initialised_data[keys.front()];
    for (const syntax::NamedArg& arg : item->args) {
      if (!arg.name.text.empty()) collected->insert(std::string(arg.name.text));
    }
  }
}

// Fills what says who sees whom. A package that is not there is reported; its names are missing then.
void declare_packages(ModelBuilder& b, const std::vector<const syntax::Syntax*>& packages) {
  Model& model = b.model;
  model.package_of_file.assign(b.sources.size(), static_cast<std::uint32_t>(packages.size() - 1));
  for (const syntax::Syntax* syntax : packages) {
    const syntax::Package& package = *syntax->package;
    const auto row = static_cast<std::uint32_t>(model.packages.size());
    const std::string name = package.name.parts.empty() ? "" : b.text(package.name);
    PackageScope scope{
        .name = name, .prefix = syntax == packages.back() ? "" : name + ".", .file = syntax->file, .uses = {}};
    for (const syntax::Path& use : package.uses) {
      const std::string wanted = b.text(use);
      const auto used = std::find_if(model.packages.begin(), model.packages.end(),
                                     [&](const PackageScope& p) { return p.name == wanted; });
      const auto used_row = static_cast<std::uint32_t>(used - model.packages.begin());
      if (used == model.packages.end()) {
        b.diags.report(Diag::kB1060, use.range, wanted);
      } else if (std::find(scope.uses.begin(), scope.uses.end(), used_row) == scope.uses.end()) {
        scope.uses.push_back(used_row);
      } else {
        b.diags.report(Diag::kB1066, use.range, wanted).help("remove this line");
      }
    }
    if (syntax->file.value < model.package_of_file.size()) model.package_of_file[syntax->file.value] = row;
    model.packages.push_back(std::move(scope));
    model.decls.insert(model.decls.end(), package.decls.begin(), package.decls.end());
  }
  model.package = model.packages.back().name;
}

}  // namespace

std::optional<Model> build_model(const syntax::Syntax& syntax, const SourceMap& sources, Diagnostics& diags) {
  return build_model(std::vector<const syntax::Syntax*>{&syntax}, sources, diags);
}

std::optional<Model> build_model(const std::vector<const syntax::Syntax*>& packages, const SourceMap& sources,
                                 Diagnostics& diags) {
  Model model;
  model.sources = &sources;
  for (std::size_t i = 0; i < sources.size(); ++i) model.files.push_back(sources.name(FileId(i)));
  model.code.string("");
  for (const syntax::Syntax* syntax : packages) {
    if (syntax->package == nullptr) return std::nullopt;
  }
  ModelBuilder b{model, diags, sources, {}};
  declare_packages(b, packages);
  declare_names(b);
  declare_ffi_types(b);
  check_prototypes(b);
  collect_cpp(b, packages);
  build_constants(b);
  check_functions(b);
  for (const syntax::Decl* decl : model.decls) {
    collect_initialised_data(b, decl->items);
    check_suppressions(diags, *decl);
  }
  build_port_types(b);
  build_atom_types(b);
  build_connector_types(b);
  build_compound_types(b);
  if (diags.has_errors()) return std::nullopt;
  return model;
}

}  // namespace bip::model
