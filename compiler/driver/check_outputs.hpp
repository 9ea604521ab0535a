// No output of a command replaces one of its inputs.
#pragma once
#include <string>
#include <vector>

#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::driver {

/// Compares the files that the command will write with those that it has read: sources, packages, files of `@cpp`.
/// Empty paths are none; devices may be both. Returns false after a report (B5013). Files that options name are
/// compared before, by file_conflict(); `inputs` are those that an output whose name is a default could replace.
[[nodiscard]] bool check_outputs(Compilation& c, const std::vector<std::string>& outputs,
                                 const std::vector<std::string>& inputs = {});

/// The same for a folder that is removed before its files are written: no input may lie in it.
[[nodiscard]] bool check_replaced_folder(Compilation& c, const std::string& folder);

/// Returns whether the outputs can be written, before the model's C++ is loaded for a result that would be lost; false
/// after a report (B5004).
[[nodiscard]] bool check_writable(Compilation& c, const std::vector<std::string>& outputs);

}  // namespace bip::driver
