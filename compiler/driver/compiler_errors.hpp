// Translates errors of the host's C++ compiler to diagnostics of the model.
#pragma once
#include <string>

#include "compiler/driver/pipeline.hpp"

namespace bip::driver {

/// True if `word` stands in `text` by itself, not in a longer name.
[[nodiscard]] bool has_word(const std::string& text, const std::string& word);

/// The shared object of `bipc run` could not be made: the prototype or type that C++ does not have, or the first thing
/// that the compiler said.
void report_cpp_failure(Compilation& c, const std::string& said);

/// The same of `bipc build`. What cannot be told by a prototype is told by the line of the model, if the compiler names
/// one. Its own text follows, without the path of the folder `work`. `how`: "exit code 1".
void report_build_failure(Compilation& c, const std::string& compiler, const std::string& how, std::string said,
                          const std::string& work);

}  // namespace bip::driver
