// Parses text to a syntax tree. The only folder that includes ANTLR.
#pragma once
#include <optional>
#include <string>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/parse/piece_cache.hpp"
#include "compiler/syntax/syntax.hpp"

namespace bip::parse {

/// Deepest nesting of parentheses, blocks and groups that is read; deeper is diagnostic B0xxx, not a crash.
inline constexpr int kMaxDepth = 500;

/// Parses one file. Reports all that it can find and returns the declarations that could be read;
/// nullopt only if nothing is usable. Never throws, never prints.
/// `kept` (may be null): the pieces of an earlier text of the file, and then of this one. A sound file is then parsed
/// only where it differs, with the same result; its nodes belong to `kept` and are valid until the next call with it.
[[nodiscard]] std::optional<syntax::Syntax> parse_file(const SourceMap& sources, FileId file, Diagnostics& diags,
                                                       PieceCache* kept = nullptr);

/// The same at the cost of what changed since the text of `kept`. nullopt, and no message, where that does not suffice:
/// there is no earlier text, or the errors reach further than a few declarations.
[[nodiscard]] std::optional<syntax::Syntax> parse_incrementally(const SourceMap& sources, FileId file,
                                                                Diagnostics& diags, PieceCache& kept);

/// One token a line: `line:column  KIND  text` (for --emit=tokens).
[[nodiscard]] std::string dump_tokens(const SourceMap& sources, FileId file);

/// `Root(1, 2.5, true, "s")` of --root. The expression must be a call or a name.
struct RootSpec {
  std::string type;
  std::vector<const syntax::Expr*> args;
  std::unique_ptr<Arena> arena;
};
[[nodiscard]] std::optional<RootSpec> parse_root(SourceMap& sources, const std::string& text, Diagnostics& diags);

}  // namespace bip::parse
