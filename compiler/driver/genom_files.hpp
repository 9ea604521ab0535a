// Shared by `bipc genom` and `bipc rules`: reading files and options, writing files.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/genom/translate.hpp"

namespace bip::driver {

/// `package`: the name if the command line gives none.
[[nodiscard]] genom::TranslateOptions translate_options(const GenomArguments& arguments,
                                                        const std::vector<std::string>& files,
                                                        const std::string& package);
/// Parsed, resolved and checked; nothing if there are errors. `side_file`: may be empty.
[[nodiscard]] std::optional<std::vector<genom::Module>> load_modules(Compilation& c,
                                                                     const std::vector<std::string>& files,
                                                                     const std::string& side_file,
                                                                     const genom::TranslateOptions& options);
/// In house style, to the output or standard output, with a skeleton if that is asked for.
void write_translation(Compilation& c, const GenomArguments& arguments, const genom::Translation& translation,
                       const std::string& package);
/// `text` as `bipc fmt` prints it.
[[nodiscard]] std::string formatted(const std::string& text);

}  // namespace bip::driver
