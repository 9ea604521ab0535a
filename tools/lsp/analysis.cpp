// See analysis.hpp.
#include "tools/lsp/analysis.hpp"

#include <utility>

#include "compiler/system/system.hpp"

namespace bip::lsp {

namespace {

const std::string* path_in(const pipeline::Compilation* compilation, FileId id) {
  if (compilation == nullptr) return nullptr;
  const auto found = compilation->paths.find(id);
  return found == compilation->paths.end() ? nullptr : &found->second;
}

}  // namespace

const std::string* Analysis::path_of(FileId id) const { return path_in(compilation.get(), id); }
const std::string* Findings::path_of(FileId id) const { return path_in(compilation, id); }

Findings take_findings(const pipeline::Compilation& c) {
  Findings f;
  f.compilation = &c;
  f.diagnostics = c.diags.sorted();
  f.file = c.file;
  return f;
}

void forget_products(pipeline::Compilation& c) {
  // An instantiated system may be large.
  c.system.reset();
  c.model.reset();
  c.packages.clear();
  c.used.clear();
  c.syntax.reset();
  c.open_texts.clear();
  c.kept = nullptr;
}

Analysis take_names(std::unique_ptr<pipeline::Compilation> c) {
  Analysis a;
  a.file = c->file;
  if (c->syntax.has_value() && c->syntax->package != nullptr && c->packages.empty()) c->packages.push_back(&*c->syntax);
  a.index = index::build_index(c->packages, c->sources);
  a.compilation = std::move(c);
  return a;
}

}  // namespace bip::lsp
