// The net as a graph for Graphviz: what the structural engines see of a model.
#pragma once
#include <string>

#include "compiler/verify/net/net.hpp"

namespace bip::verify {

/// Returns a DOT graph of a net that is usable: a cluster per atom with its modes (initial ones with two borders), its
/// moves, labelled by port, and its ports; then a node per group of a connector, with edges to what it is made of.
/// Edges to triggers are dashed. Linear in the net.
[[nodiscard]] std::string net_dot(const Net& net);

}  // namespace bip::verify
