// What a property of states may be if components are in local states by regions.
#pragma once
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "compiler/verify/property/property.hpp"
#include "compiler/verify/regions/local_space.hpp"

namespace bip::verify {

class PropertyRanges {
 public:
  using SpaceOf = std::function<const LocalSpace&(u32 atom)>;

  /// `property` must outlive it; `space_of` gives the space of each component that the property names.
  PropertyRanges(const Property& property, SpaceOf space_of) : property_(property), space_of_(std::move(space_of)) {}

  /// What a node about one component is in one of its states.
  [[nodiscard]] Range of_state(const PropertyNode& node, u32 state) const;
  /// May the condition have this value, or end in a run-time error, if each named component is in this state?
  [[nodiscard]] bool may_be(bool value, const std::map<u32, u32>& state_of) const;

 private:
  [[nodiscard]] Range evaluate(const PropertyNode& node, const std::vector<Range>& ranges,
                               const std::map<u32, u32>& state_of) const;

  const Property& property_;
  SpaceOf space_of_;
};

}  // namespace bip::verify
