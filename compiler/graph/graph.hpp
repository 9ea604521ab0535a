// Writes a System as DOT for Graphviz, or as JSON for other programs. The formats are described in
// compiler/docs/cli.md, `bipc graph`.
//
// Requires a System that `validate` accepts. Deterministic: rows in table order. Linear in the System and its code.
#pragma once
#include <string>

#include "compiler/system/system.hpp"

namespace bip::graph {

/// Structure: component instances and connectors. Automata: one of each atom type.
enum class Show : std::uint8_t { All, Structure, Automata };

/// Returns the text for Graphviz; layout is left to it.
[[nodiscard]] std::string dot(const System& system, Show show = Show::All);
/// Returns one JSON object with a final newline; code is in it whole, as BIP text.
[[nodiscard]] std::string json(const System& system, Show show = Show::All);

}  // namespace bip::graph
