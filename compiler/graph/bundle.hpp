// Bundles: in a box with very many nets, connectors between the same closed boxes become one line.
#pragma once
#include "compiler/graph/scene.hpp"

namespace bip::graph {

/// Replaces nets of open boxes that have more than `most` of them: connectors that join the same closed boxes and
/// atoms, together with what only they bind, become one net with one port on each box. Ports that nothing joins any
/// more disappear. Linear in the ends, except for sorting.
void bundle_nets(Scene& scene, std::uint64_t most);

}  // namespace bip::graph
