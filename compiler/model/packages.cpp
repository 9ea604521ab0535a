// See packages.hpp.
#include "compiler/model/packages.hpp"

#include <algorithm>

#include "compiler/model/code_builder.hpp"

namespace bip::model {

const PackageScope& package_of(const Model& model, FileId file) {
  return file.value < model.package_of_file.size() ? model.packages[model.package_of_file[file.value]]
                                                   : model.packages.back();
}

std::string own_key(const Model& model, std::string_view name, FileId file) {
  const PackageScope& package = package_of(model, file);
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return package.prefix + std::string(name);
  const std::string_view qualifier = name.substr(0, dot);
  const std::string_view last = name.substr(dot + 1);
  if (qualifier == package.name) return package.prefix + std::string(last);
  std::string key;
  for (const std::uint32_t row : package.uses) {
    if (model.packages[row].name == qualifier) key = model.packages[row].prefix + std::string(last);
  }
  return key;
}

std::vector<std::string> used_keys(const Model& model, std::string_view name, FileId file) {
  std::vector<std::string> keys;
  if (name.find('.') != std::string_view::npos) return keys;
  for (const std::uint32_t row : package_of(model, file).uses)
    keys.push_back(model.packages[row].prefix + std::string(name));
  return keys;
}

void report_ambiguous(Diagnostics& diags, SourceRange at, std::string_view name, const std::vector<std::string>& keys) {
  std::vector<std::string> packages;
  for (const std::string& key : keys) packages.push_back(key.substr(0, key.rfind('.')));
  std::string text;
  for (const std::string& package : packages)
    text += (text.empty() ? "`" : &package == &packages.back() ? " and `" : ", `") + package + "`";
  auto d = diags.report(Diag::kB1064, at, name, text);
  for (const std::string& key : keys) d.help(fmt::format("write `{}`", key), at, key);
}

std::string shown_key(const Model& model, const std::string& key, FileId file) {
  const PackageScope& package = package_of(model, file);
  const std::size_t dot = key.rfind('.');
  const std::string prefix = dot == std::string::npos ? "" : key.substr(0, dot + 1);
  const std::string last = dot == std::string::npos ? key : key.substr(dot + 1);
  if (prefix == package.prefix) return last;
  const bool is_used = std::any_of(package.uses.begin(), package.uses.end(),
                                   [&](std::uint32_t row) { return model.packages[row].prefix == prefix; });
  return is_used ? last : "";
}

std::vector<const syntax::Decl*> visible_prototypes(const Model& model, const std::string& name, FileId file) {
  std::vector<const syntax::Decl*> all;
  std::vector<std::string> shapes;
  for (const std::string& key : visible_keys(model, model.prototypes, name, file)) {
    const std::size_t before = shapes.size();
    for (const syntax::Decl* decl : model.prototypes.find(key)->second) {
      std::string shape;
      for (const syntax::Param& p : decl->params)
        shape += (p.type.is_const ? "const " : "") + path_key(p.type.name, *model.sources) + ",";
      // A second package may repeat what the first says; within one package that is reported elsewhere.
      if (std::find(shapes.begin(), shapes.begin() + static_cast<std::ptrdiff_t>(before), shape) !=
          shapes.begin() + static_cast<std::ptrdiff_t>(before))
        continue;
      shapes.push_back(std::move(shape));
      all.push_back(decl);
    }
  }
  return all;
}

}  // namespace bip::model
