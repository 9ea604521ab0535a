// Writes a System as a picture (SVG), as DOT for Graphviz, or as JSON for other programs. The formats are described in
// compiler/docs/graph.md.
//
// Requires a System that `validate` accepts. Deterministic: rows in table order, and no float that depends on the
// machine. DOT and JSON are linear in the System and its code.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace bip {
struct System;
}

namespace bip::graph {

/// Structure: component instances and connectors. Automata: one of each atom type.
enum class Show : std::uint8_t { All, Structure, Automata };

/// Returns the text for Graphviz; layout is left to it.
[[nodiscard]] std::string dot(const System& system, Show show = Show::All);
/// Returns one JSON object with a final newline; code is in it whole, as BIP text.
[[nodiscard]] std::string json(const System& system, Show show = Show::All);

struct PictureOptions {
  Show show = Show::All;
  std::uint64_t fold = 8;                   // arrays of more elements are one box
  std::uint64_t depth = ~std::uint64_t{0};  // compounds so many levels below the root are closed
  std::uint64_t bundle = 60;      // in boxes with more connectors, those that join the same boxes are one line
  std::vector<std::string> open;  // arrays and compounds that are drawn all the same, by path
};

/// Returns a whole SVG document, laid out here.
[[nodiscard]] std::string svg(const System& system, const PictureOptions& options = {});

}  // namespace bip::graph
