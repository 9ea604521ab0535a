// Parses tokens to a module: one function per generation of GenoM. Both continue after errors; the result is complete
// only if nothing was reported.
#pragma once
#include "compiler/genom/module.hpp"
#include "compiler/genom/tokens.hpp"

namespace bip::genom {

/// GenoM 2: `module … request … poster … exec_task …`.
[[nodiscard]] Module parse_genom2(const std::vector<Token>& tokens, bool header_missing, Diagnostics& diags);

/// GenoM 3: `component … { … }`, after or among IDL declarations. A file of several components gives the first.
[[nodiscard]] Module parse_genom3(const std::vector<Token>& tokens, bool header_missing, Diagnostics& diags);

/// Which of the two it is: GenoM 3 if a `component` or `interface` stands at the top level.
[[nodiscard]] bool is_genom3(const std::vector<Token>& tokens);

}  // namespace bip::genom
