// See roots.hpp. Visits the components of every compound once.
#include "compiler/pipeline/roots.hpp"

#include <set>

#include "compiler/system/system.hpp"

namespace bip::pipeline {

std::vector<std::string> root_candidates(const Model& model) {
  std::set<CompoundTypeId> used;
  for (const CompoundType& type : model.compound_types) {
    for (const ComponentFamily& family : type.components) {
      if (family.is_compound) used.insert(family.compound);
    }
  }
  std::vector<std::string> roots;
  for (std::size_t row = 0; row < model.compound_types.size(); ++row) {
    const CompoundType& type = model.compound_types[CompoundTypeId(row)];
    const bool is_own = type.decl->name.range.file == model.packages.back().file;
    if (is_own && type.params.empty() && !used.contains(CompoundTypeId(row))) roots.push_back(type.name);
  }
  return roots;
}

std::string name_of_root(const Compilation& c) {
  std::string name = c.system->compounds.empty() ? "" : c.system->compounds.rows().front().type;
  name += '(';
  if (c.root) {
    for (const syntax::Expr* arg : c.root->args) {
      if (arg != c.root->args.front()) name += ", ";
      name += c.sources.text(arg->range);
    }
  }
  return name + ')';
}

}  // namespace bip::pipeline
