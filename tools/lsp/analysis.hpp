// What the compiler knows of one file: its names, and what its check found. Both may be of different texts: names are
// read at once, a check of a large text waits for a pause.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "compiler/index/index.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::lsp {

/// Files of the compilation are found by id in `compilation->paths`.
struct Analysis {
  std::unique_ptr<pipeline::Compilation> compilation;
  index::Index index;
  FileId file;  // the document's; none if its text was refused

  [[nodiscard]] const std::string* path_of(FileId id) const;
};

struct Findings {
  std::unique_ptr<pipeline::Compilation> own;          // unless the names are of the same compilation
  const pipeline::Compilation* compilation = nullptr;  // with the texts of the diagnostics' ranges
  std::vector<const Diagnostic*> diagnostics;          // as `bipc check` lists them
  FileId file;

  [[nodiscard]] const std::string* path_of(FileId id) const;
};

/// What a check found, as `compilation` holds it. Call it before take_names().
[[nodiscard]] Findings take_findings(const pipeline::Compilation& compilation);

/// Names of a parsed file and of the packages that were loaded with it. Names do not need its other products.
[[nodiscard]] Analysis take_names(std::unique_ptr<pipeline::Compilation> compilation);
/// Frees all but texts and diagnostics.
void forget_products(pipeline::Compilation& compilation);

}  // namespace bip::lsp
