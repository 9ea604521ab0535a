// See ffi_declarations.hpp. Sub-typing is a walk over the few FFI types of a model; resolution is quadratic in the
// prototypes of one name that fit.
#include "compiler/model/ffi_declarations.hpp"

#include <algorithm>

#include "compiler/model/packages.hpp"
#include "compiler/model/suggest.hpp"

namespace bip::model {

using syntax::DeclKind;

Type data_type(const Model& model, const syntax::TypeRef& type, Diagnostics& diags) {
  if (const std::optional<Type> native = native_type(type, diags)) return *native;
  const std::string name = path_key(type.name, *model.sources);
  if (const Type* found = find_visible(model, model.ffi_type_names, name, type.name.range, diags)) return *found;
  auto d = diags.report(Diag::kB1003, type.name.range, name);
  std::vector<std::string> known;
  for (const auto& [key, row] : model.ffi_type_names) {
    if (std::string shown = shown_key(model, key, type.name.range.file); !shown.empty())
      known.push_back(std::move(shown));
  }
  std::sort(known.begin(), known.end());
  const std::vector<std::string> similar = similar_names(name, known);
  for (const std::string& s : similar) d.help(fmt::format("`{}` has a similar name", s), type.name.range, s);
  if (!similar.empty()) return Type::Int;
  if (const std::optional<Type> meant = meant_type(name)) {
    d.help(fmt::format("write `{}`", name_of(*meant)), type.name.range, std::string(name_of(*meant)));
    return *meant;
  }
  if (name == "clock") d.note("clocks are declared by `clock NAME`");
  d.help("the native types are `int`, `bool`, `float` and `string`");
  return Type::Int;
}

Type native_data_type(const Model& model, const syntax::TypeRef& type, const char* what, Diagnostics& diags) {
  const Type found = data_type(model, type, diags);
  if (!is_ffi(found)) return found;
  diags.report(Diag::kB1046, type.name.range, what, model.code.type_name(found));
  return Type::Int;
}

bool refines(const CodeTable& code, Type type, Type wanted) {
  std::vector<Type> todo{type};
  std::vector<bool> seen(code.ffi_types.size());
  while (!todo.empty()) {
    const Type at = todo.back();
    todo.pop_back();
    if (at == wanted) return true;
    if (!is_ffi(at) || seen[ffi_row(at)]) continue;
    seen[ffi_row(at)] = true;
    for (const Type base : code.ffi_types[ffi_row(at)].refines) todo.push_back(base);
  }
  return false;
}

std::string types_text(const CodeTable& code, const std::vector<Argument>& args) {
  std::string text;
  for (const Argument& arg : args) text += (text.empty() ? "" : ", ") + code.type_name(arg.typed.type);
  return text;
}

namespace {

Type quiet_type(const Model& model, const syntax::TypeRef& type) {
  Diagnostics quiet;  // prototypes were checked once
  return data_type(model, type, quiet);
}

bool converts(const CodeTable& code, Type from, Type to) {
  return refines(code, from, to) || (from == Type::Int && to == Type::Float);
}

bool fits_prototype(const Model& model, const syntax::Decl& prototype, const std::vector<Argument>& args) {
  if (prototype.params.size() != args.size()) return false;
  for (std::size_t k = 0; k < args.size(); ++k) {
    const Type wanted = quiet_type(model, prototype.params[k].type);
    if (!converts(model.code, args[k].typed.type, wanted)) return false;
    // A native value that may not change is passed as a copy; an object is not.
    if (is_ffi(wanted) && !prototype.params[k].type.is_const && !args[k].is_variable) return false;
  }
  return true;
}

/// Parameters that say `const` for a variable, or do not for a value: only the last word between equal types.
std::size_t mismatches(const syntax::Decl& prototype, const std::vector<Argument>& args) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < args.size(); ++k)
    count += prototype.params[k].type.is_const == args[k].is_variable ? 1 : 0;
  return count;
}

bool is_more_specific(const Model& model, const syntax::Decl& a, const syntax::Decl& b,
                      const std::vector<Argument>& args) {
  bool all_equal = true;
  for (std::size_t k = 0; k < args.size(); ++k) {
    const Type x = quiet_type(model, a.params[k].type);
    const Type y = quiet_type(model, b.params[k].type);
    if (!converts(model.code, x, y)) return false;
    all_equal = all_equal && x == y;
  }
  return !all_equal || mismatches(a, args) < mismatches(b, args);
}

}  // namespace

std::string prototype_text(const Model& model, const syntax::Decl& prototype) {
  const auto type = [&](const syntax::TypeRef& t) {
    return (t.is_const ? "const " : "") + path_key(t.name, *model.sources);
  };
  std::string text = prototype.result.is_written() ? type(prototype.result) + " " : "";
  text += prototype.kind == DeclKind::ExternOperator ? "operator " + std::string(prototype.op.text)
                                                     : std::string(prototype.name.text);
  text += "(";
  for (const syntax::Param& p : prototype.params) text += (&p == &prototype.params[0] ? "" : ", ") + type(p.type);
  return text + ")";
}

std::vector<const syntax::Decl*> best_prototypes(const Model& model, const std::vector<const syntax::Decl*>& prototypes,
                                                 const std::vector<Argument>& args) {
  std::vector<const syntax::Decl*> fitting, best;
  for (const syntax::Decl* p : prototypes) {
    if (fits_prototype(model, *p, args)) fitting.push_back(p);
  }
  for (const syntax::Decl* p : fitting) {
    const bool beaten = std::any_of(fitting.begin(), fitting.end(), [&](const syntax::Decl* q) {
      return q != p && is_more_specific(model, *q, *p, args) && !is_more_specific(model, *p, *q, args);
    });
    if (!beaten) best.push_back(p);
  }
  return best;
}

std::uint32_t function_row(CodeTable& code, Function function) {
  for (std::size_t row = 0; row < code.functions.size(); ++row) {
    const Function& f = code.functions[row];
    const bool same_place =
        f.loc.file == function.loc.file && f.loc.line == function.loc.line && f.loc.column == function.loc.column;
    if (same_place && f.kind == function.kind && f.name == function.name && f.is_const == function.is_const &&
        f.has_result == function.has_result && f.result == function.result && f.params == function.params) {
      return static_cast<std::uint32_t>(row);
    }
  }
  code.functions.push_back(std::move(function));
  return static_cast<std::uint32_t>(code.functions.size() - 1);
}

bool calls_cpp(const CodeTable& code, ExprId expr) {
  std::vector<ExprId> todo{expr};
  while (!todo.empty()) {
    const ExprId id = todo.back();
    todo.pop_back();
    if (!id.is_valid()) continue;
    const Expr& e = code.exprs[id];
    if (e.op == Op::Call) return true;
    todo.insert(todo.end(), {e.a, e.b});
  }
  return false;
}

void declare_ffi_types(ModelBuilder& b) {
  CodeTable& code = b.model.code;
  std::vector<const syntax::Decl*> decls;
  for (const syntax::Decl* decl : b.model.decls) {
    if (decl->kind != DeclKind::ExternType) continue;
    const std::string cpp(decl->cpp_name.empty() ? decl->name.text : decl->cpp_name);
    b.model.ffi_type_names[b.key(*decl)] = ffi_type(code.ffi_types.size());
    code.ffi_types.push_back({std::string(decl->name.text), cpp, {}, b.loc(decl->name.range)});
    decls.push_back(decl);
  }
  for (std::size_t row = 0; row < decls.size(); ++row) {
    for (const syntax::Path& base : decls[row]->refines) {
      const Type type = data_type(b.model, {.name = base, .is_const = false}, b.diags);
      if (refines(code, type, ffi_type(row))) {
        b.diags.report(Diag::kB1044, base.range, decls[row]->name.text);
      } else {
        code.ffi_types[row].refines.push_back(type);
      }
    }
  }
}

void check_prototypes(ModelBuilder& b) {
  for (const syntax::Decl* decl : b.model.decls) {
    if (decl->kind != DeclKind::ExternFunction && decl->kind != DeclKind::ExternOperator) continue;
    for (const syntax::Param& p : decl->params) (void)data_type(b.model, p.type, b.diags);
    if (decl->result.is_written()) (void)data_type(b.model, decl->result, b.diags);
    auto& rows = decl->kind == DeclKind::ExternFunction ? b.model.prototypes[b.key(*decl)]
                                                        : b.model.operators["operator " + std::string(decl->op.text)];
    for (const syntax::Decl* other : rows) {
      const bool same = other->range.file == decl->range.file &&
                        std::equal(other->params.begin(), other->params.end(), decl->params.begin(), decl->params.end(),
                                   [&](const syntax::Param& x, const syntax::Param& y) {
                                     return x.type.is_const == y.type.is_const &&
                                            quiet_type(b.model, x.type) == quiet_type(b.model, y.type);
                                   });
      if (!same) continue;
      b.diags.report(Diag::kB1048, decl->range, prototype_text(b.model, *decl)).label(other->range, "here first");
      break;
    }
    rows.push_back(decl);
  }
}

void collect_cpp(ModelBuilder& b, const std::vector<const syntax::Syntax*>& packages) {
  FfiFiles& cpp = b.model.code.cpp;
  for (const syntax::Syntax* syntax : packages) {
    const std::string file = b.sources.name(syntax->file);
    const std::size_t slash = file.rfind('/');
    const std::string folder = slash == std::string::npos ? "" : file.substr(0, slash + 1);
    for (const syntax::Annotation& annotation : syntax->package->annotations) {
      if (annotation.name.text != "cpp") continue;
      for (const syntax::AnnotationArg& arg : annotation.args) {
        std::vector<CppFile>* files = arg.key.text == "include" ? &cpp.includes
                                      : arg.key.text == "src"   ? &cpp.sources
                                      : arg.key.text == "obj"   ? &cpp.objects
                                                                : nullptr;
        if (files == nullptr) {
          b.diags.report(Diag::kB1047, arg.key.range, arg.key.text).help("it takes `include`, `src` and `obj`");
          continue;
        }
        std::string_view rest = arg.value;
        while (!rest.empty()) {
          const std::size_t comma = rest.find(',');
          std::string_view name = rest.substr(0, comma);
          rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
          while (!name.empty() && name.front() == ' ') name.remove_prefix(1);
          while (!name.empty() && name.back() == ' ') name.remove_suffix(1);
          const CppFile entry{folder, std::string(name)};
          if (!name.empty() && std::find(files->begin(), files->end(), entry) == files->end()) files->push_back(entry);
        }
      }
    }
  }
}

}  // namespace bip::model
