// Translates errors of the host's C++ compiler to diagnostics of the model.
#pragma once
#include <string>

#include "compiler/pipeline/pipeline.hpp"

namespace bip::pipeline {

/// True if `word` stands in `text` by itself, not in a longer name.
[[nodiscard]] bool has_word(const std::string& text, const std::string& word);

/// A file that `@cpp` names is in none of the folders: B5010.
void report_missing_file(Compilation& c, const std::string& name);

/// The shared object of `bipc run` could not be made: the prototype or type that C++ does not have, or the first thing
/// that the compiler said. `near`: more about it, or empty.
void report_cpp_failure(Compilation& c, const std::string& said, const std::string& near);
/// The C function that the linker misses; empty if it is another failure.
[[nodiscard]] std::string missing_c_function(const std::string& said);
/// Of warnings by `-Wmissing-declarations`: "file.cc:12: no previous declaration for 'int f(double)'" of a function
/// `name`; empty if there is none.
[[nodiscard]] std::string other_declaration(const std::string& warnings, const std::string& name);

/// Reports that the program of `bipc build` does not compile or link: the missing prototype if there is one, else the
/// line of the model that the compiler names. Appends the compiler's text without the path of the folder `work`. `how`:
/// how the compiler ended, "exit code 1".
void report_build_failure(Compilation& c, const std::string& compiler, const std::string& how, std::string said,
                          const std::string& work);

}  // namespace bip::pipeline
