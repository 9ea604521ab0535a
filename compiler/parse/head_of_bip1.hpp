// Tells a file of BIP1 from one of BIP2, without BIP1's grammar.
#pragma once
#include "compiler/source/source.hpp"

namespace bip::parse {

/// `model Name` at the beginning of a file of BIP1, else no range.
[[nodiscard]] SourceRange head_of_bip1(const SourceMap& sources, FileId file);

}  // namespace bip::parse
