// The printer: `bipc fmt` and `--emit=syntax`.
#pragma once
#include <string>

#include "compiler/syntax/syntax.hpp"

namespace bip::syntax {

/// The file in house style, each declaration in the notation that it was written in, comments kept (before the
/// declaration or statement they preceded, or at the end of the line they followed). Idempotent:
/// print(parse(print(x))) == print(x).
[[nodiscard]] std::string print(const Syntax& syntax, const SourceMap& sources);

/// An indented tree with kinds and line:column ranges, for goldens.
[[nodiscard]] std::string dump(const Syntax& syntax, const SourceMap& sources);

}  // namespace bip::syntax
