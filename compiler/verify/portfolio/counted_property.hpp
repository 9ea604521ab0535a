// Properties that count conditions about interchangeable components: `always at most 1 i in station: station[i]@SENDS`.
// If any of them may change places with any other, the first ones stand for all: a run to a state where some two are
// true has an image in which the first two are.
//
// C. N. Ip, D. Dill: Better Verification Through Symmetry (1996).
#pragma once
#include <optional>

#include "compiler/system/system_ids.hpp"
#include "compiler/verify/property/property.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::verify {

/// Returns the property about so many of the first conditions as may not be true together, which holds exactly if
/// `property` does; its text is the same. Nothing if it counts none, or more than that are needed, or they are not
/// found to be interchangeable: each about one member of a group, and the image of the others; what stands beside them
/// about none. With time, too; not with C++ or priorities. Cost: limited, about a second at most.
[[nodiscard]] std::optional<Property> with_first_conditions(const Property& property, const rt::Image& image);

/// The same where each condition is about one component of an array without what is inside others, and all say the same
/// of theirs: a candidate. `property` holds if the result does, and if a proof of the result is one for any components
/// of that array (compiler/verify/timed/prove_pairs.hpp). Nothing if the conditions are not so.
[[nodiscard]] std::optional<Property> with_first_of_array(const Property& property, const System& system);

}  // namespace bip::verify
