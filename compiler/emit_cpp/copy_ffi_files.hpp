// Copies the C++ files of a model into an emitted project, so that the project can be moved. Internal to emit_cpp/.
#pragma once
#include <filesystem>
#include <string>

#include "compiler/emit_cpp/emit_cpp.hpp"

namespace bip::emit_cpp {

/// Copies sources, objects and headers into `project`/ffi, with all that they include and that is found beside them
/// or in the include folders. The result's paths are relative to `project`; folders lie to each other as they did.
[[nodiscard]] Result<CppBuild> copy_ffi_files(const CppBuild& cpp, const std::filesystem::path& project);

// project.cpp
/// A file that has this text already is left untouched.
[[nodiscard]] Result<bool> update_file(const std::filesystem::path& path, const std::string& text);

}  // namespace bip::emit_cpp
