// Translates .gen files to one BIP text, for `bipc genom` and the tests.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/preprocess.hpp"
#include "compiler/genom/resolve_module.hpp"

namespace bip::genom {

/// Are types and data of a GenoM 3 component read, too (idl.hpp)?
enum class Types : std::uint8_t { Skipped, Read };

struct TranslateOptions {
  PreprocessOptions preprocess;
  GenerateOptions generate;
  std::vector<std::string> codel_files;  // with generate.calls_c: as they can be opened from here
  std::size_t instances = 1;
  Types types = Types::Skipped;
};
struct Description {
  std::string path;  // headers are looked for beside it
  FileId file;
};

/// `codel_header`, `codel_source`: of the execution flavour, codels that answer the first thing permitted.
struct Translation {
  std::string bip, codel_header, codel_source;
  std::vector<std::pair<std::string, std::string>> c_files;  // names and texts, if codels are in C
};

/// One description, parsed and not yet resolved.
[[nodiscard]] Module read_module(SourceMap& sources, const Description& description, const PreprocessOptions& options,
                                 Diagnostics& diags, Types types = Types::Skipped);

/// All of them, resolved and checked; nothing if there are errors. `side`: the lines of the side file.
[[nodiscard]] std::optional<std::vector<Module>> read_modules(SourceMap& sources, const std::vector<Description>& files,
                                                              std::vector<SideLine> side,
                                                              const TranslateOptions& options, Diagnostics& diags);
/// The package's name if no option gives one.
[[nodiscard]] std::string package_of(const std::vector<Module>& modules);
/// Modules that `read_modules` gave, as one functional level.
[[nodiscard]] Translation write_package(const std::vector<Module>& modules, const GenerateOptions& options);

}  // namespace bip::genom
