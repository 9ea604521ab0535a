// Bad states over local states by regions: those that may violate a property, and those in which no interaction is
// possible for sure.
#pragma once
#include <optional>
#include <vector>

#include "compiler/verify/property/property.hpp"
#include "compiler/verify/regions/exclusion_program.hpp"
#include "compiler/verify/regions/local_space.hpp"

namespace bip::verify {

/// By component its local states.
struct RegionSpaces {
  std::vector<LocalSpace> spaces;
  std::vector<u32> first;  // by component: the number of its first state in the program
};

/// The components that the property names are in one of these states each.
struct BadRegions {
  std::vector<u32> atoms;
  std::vector<std::vector<u32>> states;  // by atom of `atoms`, ascending; numbers of the component's space
};
/// Returns all combinations that may violate the property; nothing: they are too many, or the property is about what
/// connectors offer, or names no component.
[[nodiscard]] std::optional<std::vector<BadRegions>> find_bad_regions(const RegionNet& net, const Property& property,
                                                                      const std::vector<LocalSpace>& spaces);

/// Adds that no interaction is possible for sure: of one component's states, or of two components'. The source is the
/// connector's row, or the number of a port's step (RegionNet::first_own_step). False: the time is over.
[[nodiscard]] bool add_deadlock(const RegionNet& net, const RegionSpaces& spaces, ExclusionProgram& program,
                                const CancellationToken& cancellation);

}  // namespace bip::verify
