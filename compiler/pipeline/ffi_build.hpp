// The FFI of a model: where its files are, and for `bipc run` a shared object with everything that is called.
//
// The object is compiled by the host compiler and kept in the cache, with a hash of what the preprocessor makes of its
// units: a copy that was checked is loaded. A model that calls nothing needs none of this.
#pragma once
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/emit_cpp/emit_cpp.hpp"

namespace bip::pipeline {

[[nodiscard]] bool uses_ffi(const Compilation& c);

/// The files that `@cpp` names: below the package's folder, its `ext-cpp`, the -I folders and theirs. False if a source
/// or an object is missing (reported). A header that is in none of them is left to the C++ compiler: `stdio.h`.
[[nodiscard]] bool find_ffi_files(Compilation& c, emit_cpp::CppBuild& out);

/// Compiles and loads the shared object and fills c.lowered's functions and FFI types. False after a report; what
/// C++ does not have is told by its prototype.
[[nodiscard]] bool load_ffi(Compilation& c, const CacheOptions& cache);

}  // namespace bip::pipeline
