// Deprecated spellings, which compile with a warning, and their replacements. `bipc migrate` applies them.
#pragma once
#include <string>
#include <vector>

#include "compiler/syntax/syntax.hpp"

namespace bip::syntax {

/// The text of `range` becomes `with`.
struct Edit {
  SourceRange range;
  std::string with;
};

/// In source order, without overlaps. Today: `double`, which is `float`, and declarations of native types, which go.
[[nodiscard]] std::vector<Edit> deprecated_spellings(const Syntax& syntax, std::string_view text);

}  // namespace bip::syntax
