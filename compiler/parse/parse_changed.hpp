// Parses a sound file whose earlier text is known: only the pieces that changed. Inside compiler/parse only.
#pragma once
#include <functional>
#include <optional>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/parse/piece_cache.hpp"
#include "compiler/parse/token_list.hpp"
#include "compiler/syntax/syntax.hpp"

namespace bip::parse {

/// The tree that `parse_file` gives, with nodes in `kept`, which is brought up to date. Nothing if there is something
/// to report, or if the file has parts that cannot be read alone; `kept` is as before then.
[[nodiscard]] std::optional<syntax::Syntax> parse_changed(const SourceMap& sources, FileId file, PieceCache& kept);

/// The tree of a text that is not sound, with the messages that `parse_file` gives, where all errors are in a few
/// pieces that follow each other: these, the first piece and the one behind them are read as a file, by `read`.
/// Nothing, and no message, if it is not so; `kept` stays as it is but for the places of its pieces.
using ReadDamaged = std::function<const syntax::Package*(const TokenList& list, Arena& arena, Diagnostics& diags)>;
[[nodiscard]] std::optional<syntax::Syntax> parse_damaged(const SourceMap& sources, FileId file, PieceCache& kept,
                                                          Diagnostics& diags, const ReadDamaged& read);

}  // namespace bip::parse
