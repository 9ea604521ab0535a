// Parses a sound file whose earlier text is known: only the pieces that changed. Inside compiler/parse only.
#pragma once
#include <optional>

#include "compiler/parse/kept_pieces.hpp"
#include "compiler/syntax/syntax.hpp"

namespace bip::parse {

/// The tree that `parse_file` gives, with nodes in `kept`, which is brought up to date. Nothing if there is something
/// to report, or if the file has parts that cannot be read alone; `kept` is as before then.
[[nodiscard]] std::optional<syntax::Syntax> parse_changed(const SourceMap& sources, FileId file, KeptPieces& kept);

}  // namespace bip::parse
