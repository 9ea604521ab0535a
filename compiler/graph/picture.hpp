// The pictures that svg.cpp puts together, and that pages take one by one. Internal to graph/ and its pages.
//
// Elements carry what a page needs to find them: boxes `data-atom` (row of the System; of a folded array the first),
// `data-compound` and `data-path`; nets `data-connector` and `data-last` (rows); places `data-place`, transitions
// `data-transition` (rows of the atom type).
#pragma once
#include "compiler/graph/graph.hpp"
#include "compiler/graph/shapes.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::graph {

/// Components, ports and connectors.
[[nodiscard]] Picture structure_picture(const System& system, const PictureOptions& options);
/// Places and transitions of an atom type, with its name and its data above.
[[nodiscard]] Picture automaton_picture(const System& system, AtomTypeId type);

}  // namespace bip::graph
