// Parses BIP1, the language before BIP2, for `bipc migrate`.
#pragma once
#include <optional>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/syntax/bip1.hpp"

namespace bip::parse {

/// The tree of a file of BIP1; nullopt after the first syntax error, which is reported. Never throws, never prints.
[[nodiscard]] std::optional<syntax::bip1::Model> parse_bip1(const SourceMap& sources, FileId file, Diagnostics& diags);

}  // namespace bip::parse
