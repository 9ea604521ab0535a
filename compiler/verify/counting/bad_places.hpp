// The bad states of a property as sets of places of the counted net: each component that the property names has its
// token in one of these.
//
// Local states of a component that look the same to the property (its places, its data and its ports, as far as the
// property names them) are one class. The property is evaluated by the core once for each combination of classes, and
// bad combinations that differ in one component are joined.
#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "compiler/verify/counting/counted_net.hpp"
#include "compiler/verify/property/property.hpp"

namespace bip::verify {

/// Bad are the markings that have a token in each of these sets. Sets of different components, each sorted.
struct BadPlaces {
  std::vector<std::vector<u32>> sets;
};

/// Returns all of them; nothing: there are too many combinations, or the property is about what connectors offer.
/// `is_bad`: of the state that the core is in. Each component that the property names is of a kind of its own.
[[nodiscard]] std::optional<std::vector<BadPlaces>> find_bad_places(CountedNetBuilder& builder,
                                                                    const Property& property,
                                                                    const std::function<bool(const rt::Core&)>& is_bad);

}  // namespace bip::verify
