// Quoting and labels of DOT text, shared by dot_structure.cpp and dot_automata.cpp. Internal to graph/.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "compiler/system/system_ids.hpp"

namespace bip::graph {

/// Longer pieces of code are cut in pictures; the JSON has them whole.
inline constexpr std::size_t kMaxLabel = 72;

/// Returns "text" for DOT: quotes and backslashes escaped, newlines as \n, bytes that are no UTF-8 as ?.
[[nodiscard]] std::string dot_string(std::string_view text);
/// Returns the same for a field of a record: its signs are escaped, too, and there are no quotes.
[[nodiscard]] std::string record_field(std::string_view text);
/// Returns at most kMaxLabel bytes of the text, cut at a character.
[[nodiscard]] std::string shortened(std::string text);
/// Joins the lines that are not empty by newlines.
[[nodiscard]] std::string lines_of(const std::vector<std::string>& lines);

/// Appends component instances, connectors, merged ports and priorities as one cluster per compound.
void put_structure(std::string& out, const System& system);
/// Appends one automaton or Petri net per atom type.
void put_automata(std::string& out, const System& system);

}  // namespace bip::graph
