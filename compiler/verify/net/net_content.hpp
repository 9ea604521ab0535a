// Names by content for what invariants are about: the modes of a component, and the network below a compound. Where
// code changes and the network does not (a guard over data that modes do not know, an action, a priority), the name
// stays.
//
// Cost: linear in classes, components and connectors; hashing is the most of it.
#pragma once
#include <string>
#include <vector>

#include "compiler/verify/net/net.hpp"

namespace bip::verify {

struct NetContent {
  std::vector<std::string> of_class;     // by class of the net
  std::vector<std::string> of_compound;  // by compound: its components by name, what is below, its connectors
};
[[nodiscard]] NetContent content_of(const Net& net);

/// "left.phil[0]" of "ROOT.left.phil[0]" below "ROOT".
[[nodiscard]] std::string path_below(const std::string& compound, const std::string& path);

}  // namespace bip::verify
