// A System as a picture and as data: DOT for Graphviz, JSON for other tools. Format: compiler/docs/cli.md, `bipc
// graph`.
//
// Needs a System that `validate` accepts. Deterministic: rows in table order. Linear in the System and its code.
#pragma once
#include <string>

#include "compiler/system/system.hpp"

namespace bip::graph {

/// Structure: component instances and connectors. Automata: one of each atom type.
enum class Show : std::uint8_t { All, Structure, Automata };

[[nodiscard]] std::string dot(const System& system, Show show = Show::All);
[[nodiscard]] std::string json(const System& system, Show show = Show::All);

}  // namespace bip::graph
