// What the compiler knows of one file: its diagnostics and names.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "compiler/index/index.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::lsp {

/// Files of the compilation are found by id in `compilation->paths`.
struct Analysis {
  std::unique_ptr<pipeline::Compilation> compilation;
  std::vector<const Diagnostic*> diagnostics;  // as `bipc check` lists them
  index::Index index;
  FileId file;  // the document's; none if its text was refused
  // How many interactions a connector type gives, by its name, without the package, and line; of a file without errors
  // in its types.
  std::map<std::pair<std::string, std::uint32_t>, double> interactions;

  [[nodiscard]] const std::string* path_of(FileId id) const;
};

/// Names of a parsed file and of the packages that were loaded with it. What is not needed for names is freed.
[[nodiscard]] Analysis take_names(std::unique_ptr<pipeline::Compilation> compilation);

}  // namespace bip::lsp
