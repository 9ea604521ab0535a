// One SVG document: the structure, and below it the automata in rows.
#include <algorithm>

#include "compiler/graph/graph.hpp"
#include "compiler/graph/picture.hpp"
#include "compiler/system/system.hpp"

namespace bip::graph {
namespace {

constexpr double kLeastWidth = 900, kSheetGap = 16, kEdge = 12;

}  // namespace

std::string svg(const System& system, const PictureOptions& options) {
  Shapes shapes;
  double width = 0, y = 0;
  if (options.show != Show::Automata) {
    const Picture structure = structure_picture(system, options);
    shapes.place(structure.elements, {0, 0});
    width = structure.width;
    y = structure.height;
  }
  if (options.show != Show::Structure) {
    const double wide = std::max(width, kLeastWidth);
    double x = kEdge, height = 0;
    y = std::max(y, kEdge);
    for (std::size_t row = 0; row < system.atom_types.size(); ++row) {
      const Picture sheet = automaton_picture(system, AtomTypeId(row));
      if (x > kEdge && x + sheet.width + kEdge > wide) {
        y += height + kSheetGap;
        x = kEdge;
        height = 0;
      }
      shapes.place(sheet.elements, {x, y});
      x += sheet.width + kSheetGap;
      width = std::max(width, x - kSheetGap + kEdge);
      height = std::max(height, sheet.height);
    }
    y += height + kEdge;
  }
  const std::string name = system.compounds.empty() ? "atom types" : system.compounds.begin()->type;
  return svg_document({shapes.elements(), width, y}, "BIP model " + name);
}

}  // namespace bip::graph
