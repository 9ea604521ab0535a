// The C preprocessor as far as descriptions need it: #include, object-like #define, #undef, #if and related directives,
// #pragma require (folders of a package; others are ignored), #error (a diagnostic).
//
// Works on tokens, so text inside of strings is not replaced. A missing header is a warning, once per file, and its
// types are opaque. Includes nest at most 64 deep; the output has at most 2^20 tokens.
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/genom/tokens.hpp"

namespace bip::genom {

struct PreprocessOptions {
  std::vector<std::string> folders;                          // -I, after the including file's own folder
  std::vector<std::pair<std::string, std::string>> defines;  // -D
  /// The folders of headers of a package, "name" or "name >= 1.2"; a Failure says why there are none. Empty: packages
  /// are not looked for.
  std::function<Result<std::vector<std::string>>(const std::string& package)> package_folders = {};
};
struct Preprocessed {
  std::vector<Token> tokens;  // the last one is End
  bool header_missing = false;
};

/// `path`: of the file to start with.
[[nodiscard]] Preprocessed preprocess(SourceMap& sources, const std::string& path, FileId file,
                                      const PreprocessOptions& options, Diagnostics& diags);

/// A description or header as text; bytes that are no UTF-8 are taken as Latin-1.
[[nodiscard]] Result<FileId> load_description(SourceMap& sources, const std::string& path);
/// The same for bytes in memory.
[[nodiscard]] std::string as_utf8(std::string bytes);

}  // namespace bip::genom
