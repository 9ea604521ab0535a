// Quoting and labels of DOT text, shared by dot_structure.cpp and dot_automata.cpp. Internal to graph/.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "compiler/system/system.hpp"

namespace bip::graph {

/// Longer pieces of code are cut in pictures; the JSON has them whole.
inline constexpr std::size_t kMaxLabel = 72;

/// "text" for DOT: quotes and backslashes escaped, newlines as \n, bytes that are no UTF-8 as ?.
[[nodiscard]] std::string dot_string(std::string_view text);
/// The same for a field of a record, whose signs are escaped, too; without the quotes.
[[nodiscard]] std::string record_field(std::string_view text);
/// At most kMaxLabel bytes, cut at a character.
[[nodiscard]] std::string shortened(std::string text);
/// The lines that are not empty, one below the other.
[[nodiscard]] std::string lines_of(const std::vector<std::string>& lines);

void put_structure(std::string& out, const System& system);
void put_automata(std::string& out, const System& system);

}  // namespace bip::graph
