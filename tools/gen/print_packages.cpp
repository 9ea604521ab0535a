// Prints a model as packages: its declarations beside types (constants, functions, the FFI as far as it is used), the
// package of each declaration, and how a package spells the names of another one.
#include <map>

#include "tools/gen/ffi_prototypes.hpp"
#include "tools/gen/print_description_code.hpp"

namespace bip::gen {
namespace {

struct Package {
  std::string name, body;
  std::vector<std::string> uses;
};

std::string bip2_code(const Expr& expr) { return text_of(expr, plain_name, Spelling::Bip2); }
bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::string constants_and_functions(const Description& model) {
  std::string text;
  for (const Var& var : model.constants)
    text += std::string("  const data ") + name_of(var.type) + " " + var.name + " = " + bip2_code(*var.init) + "\n";
  for (const InlineFunction& function : model.functions) {
    std::vector<std::string> params;
    for (const Var& var : function.params) params.push_back(std::string(name_of(var.type)) + " " + var.name);
    text += std::string("  function ") + name_of(function.result) + " " + function.name + "(" + join(params, ", ") +
            ") = " + bip2_code(function.body) + "\n";
  }
  return text;
}

/// Prototypes and types of random_ffi.hpp that the text names.
std::string ffi_declarations(const std::string& used, bool& needs_header) {
  const bool has_objects = has(used, "$Pair") || has(used, "$Wide") || has(used, "$make_two(");
  std::string text;
  if (has_objects) text += "  extern data type Pair\n  extern data type Wide refine Pair as \"::Wide\"\n";
  for (const FfiPrototype& f : ffi_functions()) {
    bool of_objects = f.result >= Ty::Pair;
    for (const FfiParam& p : f.params) of_objects = of_objects || p.type >= Ty::Pair;
    if (of_objects && !has_objects) continue;
    if (!f.is_operator && !has(used, std::string("$") + f.name + "(")) continue;
    text += std::string("  extern ") + f.prototype + "\n";
    needs_header = needs_header || !f.is_library;
  }
  needs_header = needs_header || has_objects;
  return text;
}

/// The marks replaced: names of other packages get theirs, or some of them do.
std::string resolved(const std::string& text, const std::string& package,
                     const std::map<std::string, std::string>& home, bool qualified) {
  std::string result;
  std::size_t count = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] != '$') {
      result += text[at];
      continue;
    }
    std::size_t end = at + 1;
    while (end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) != 0 || text[end] == '_')) ++end;
    const auto found = home.find(text.substr(at + 1, end - at - 1));
    if (qualified && found != home.end() && found->second != package && ++count % 3 != 0) result += found->second + ".";
  }
  return result;
}

}  // namespace

std::vector<std::string> print_packages(const Description& model) {
  const std::string base_name = "lib.base_of_" + model.package, parts_name = "lib.parts_of_" + model.package;
  const std::string words = constants_and_functions(model), types = print_types(model.port_types),
                    parts = print_parts(model), compounds = print_compounds(model);
  bool needs_header = false;
  const std::string declarations = ffi_declarations(words + types + parts + compounds, needs_header);
  const std::string base = declarations + words + types;

  std::vector<Package> packages;
  if (model.split == Split::One) packages.push_back({model.package, base + parts + compounds, {}});
  if (model.split == Split::Base) packages = {{base_name, base, {}}, {model.package, parts + compounds, {base_name}}};
  if (model.split == Split::Parts)
    packages = {
        {base_name, base, {}}, {parts_name, parts, {base_name}}, {model.package, compounds, {base_name, parts_name}}};

  std::map<std::string, std::string> home;
  for (const PortType& type : model.port_types) home[type.name] = packages.front().name;
  for (const Var& var : model.constants) home[var.name] = packages.front().name;
  for (const InlineFunction& function : model.functions) home[function.name] = packages.front().name;
  for (const FfiPrototype& f : ffi_functions()) home[f.name] = packages.front().name;
  home["Pair"] = home["Wide"] = packages.front().name;
  const std::string& of_parts = packages[packages.size() == 3 ? 1 : packages.size() - 1].name;
  for (const AtomType& type : model.atom_types) home[type.name] = of_parts;
  for (const ConnectorType& type : model.connector_types) home[type.name] = of_parts;

  std::vector<std::string> texts;
  for (const Package& package : packages) {
    std::string text = texts.empty() && needs_header ? "@cpp(include=\"random_ffi.hpp\")\n" : "";
    text += "package " + package.name + "\n";
    for (const std::string& use : package.uses) text += "  use " + use + "\n";
    if (model.draws) text += "  use std.chance\n\n";
    texts.push_back(text + resolved(package.body, package.name, home, model.qualified) + "end\n");
  }
  return texts;
}

std::string print(const Description& model) {
  std::string all;
  for (const std::string& text : print_packages(model)) all += (all.empty() ? "" : "\n") + text;
  return all;
}

}  // namespace bip::gen
