// Parses tokens to a module: one function per generation of GenoM. Both continue after errors; the result is complete
// only if nothing was reported.
#pragma once
#include "compiler/genom/module.hpp"
#include "compiler/genom/tokens.hpp"

namespace bip::genom {

/// Missing: an #include was not found, so names may be unknown.
enum class Headers : std::uint8_t { Found, Missing };

/// GenoM 2: `module … request … poster … exec_task …`.
[[nodiscard]] Module parse_genom2(const std::vector<Token>& tokens, Headers headers, Diagnostics& diags);

/// GenoM 3: `component … { … }`, after or among IDL declarations and interfaces. The module is the component of `file`,
/// with what the interfaces declare that it provides or extends; components of included files are interfaces.
[[nodiscard]] Module parse_genom3(const std::vector<Token>& tokens, FileId file, Headers headers, Diagnostics& diags);

/// Which of the two it is: GenoM 3 if a `component` or `interface` stands at the top level.
[[nodiscard]] bool is_genom3(const std::vector<Token>& tokens);

}  // namespace bip::genom
