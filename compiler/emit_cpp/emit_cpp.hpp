// Readable C++ for the lean runtime: one function per guard, action and transfer of a type, then the tables.
#pragma once
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/emit_cpp/ffi_text.hpp"
#include "compiler/lower/lower.hpp"

namespace bip::emit_cpp {

struct Options {
  std::string namespace_name = "model";  // everything is put there
  bool with_main = true;                 // main() that calls bip::rt::run_main(image, argc, argv)
  bool serves = false;                   // that main() calls bip::serve_main(image, argc, argv) instead
  bool line_directives = true;           // #line to the .bip
  ConstNames const_names{};              // C++ functions with a `const_` variant
  bool with_c_image = false;             // const bip_image* <namespace>_image(void), for C
  bool mark_ffi = false;  // what a compiler says about calls of C++ names their prototypes (ffi_text.hpp)
};
/// The text of one .cpp file that needs runtime/ only. With Options::with_main false it defines
/// `const bip::rt::Image& <namespace>::image()`.
[[nodiscard]] std::string emit(const lower::LoweredSystem& lowered, const Options& options);

/// The FFI of a model as a build needs it: absolute paths. Headers are found in the include_dirs, too.
struct CppBuild {
  std::vector<std::string> include_dirs, sources, objects, headers;
  ConstNames const_names;
};

struct ProjectOptions {
  bool with_main = true;
  std::string runtime_library;  // the runtime, compiled; linked where it exists, else the copies are compiled
  std::vector<std::string> link_folders, libraries;  // linked as well: where they are, their names (`m` of libm)
};

/// Writes model.cpp, a CMakeLists.txt and copies of the runtime's sources and of the model's FFI files into
/// `directory`, so that it builds alone, and elsewhere. `runtime_dir` is where the runtime's sources are; `cpp` what
/// the model's C++ side adds to the build.
[[nodiscard]] Result<bool> emit_project(const lower::LoweredSystem& lowered, const std::string& directory,
                                        const std::string& runtime_dir, const std::string& program_name,
                                        const CppBuild& cpp = {}, const ProjectOptions& options = {});

}  // namespace bip::emit_cpp
