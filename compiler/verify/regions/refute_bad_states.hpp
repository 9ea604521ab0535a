// Proves that no bad state is reachable by local states by regions (local_space.hpp), what two or three components
// cannot be in together (joint_explorer.hpp), and a linear program over all components (exclusion_program.hpp).
//
// First each component by itself, then with what pairs of neighbours say. For a property, pairs beside one of the
// components that the property names and that are in a bad local state: "while process 0 is critical, the last one to
// come to level 3 is still there". Variables are divided at all constants of the system; of several ints of a component
// one after the other is followed, then all, if they have few values together: what a proof counts is mostly one.
// Sound and incomplete.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/verify/property/property.hpp"
#include "compiler/verify/regions/exclusion_program.hpp"
#include "compiler/verify/regions/region_net.hpp"

namespace bip::verify {

struct RegionRefutation {
  std::size_t local_states = 0;      // of all components, of the last proof
  std::size_t explored = 0;          // pairs and triples of components
  std::size_t implications = 0;      // that proofs use
  std::vector<std::string> reasons;  // some of them, as text
  std::string rows;                  // of a certificate, if they are wanted
};
/// Are rows of a certificate wanted? Then neighbourhoods are not explored: no row says what they show.
enum class RegionRows : std::uint8_t { No, Yes };

struct RegionSearch {
  std::optional<RegionRefutation> proof;
  bool is_complete = false;  // everything was tried: more time does not help
};

/// Of deadlock if `property` is null. Ends early if the neighbourhoods that are left would take longer than there is
/// time.
[[nodiscard]] RegionSearch refute_bad_states(const RegionNet& net, const Property* property,
                                             const CancellationToken& cancellation, RegionRows rows = RegionRows::No);

}  // namespace bip::verify
