// Cuts a text where a declaration seems to begin. A wrong cut costs time only: see parse_kept.cpp.
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

namespace bip::parse {

/// Begins of the pieces, sorted; the first is 0. Each is the begin of a line. Linear in the text.
[[nodiscard]] std::vector<std::uint32_t> cut_pieces(std::string_view text);

}  // namespace bip::parse
