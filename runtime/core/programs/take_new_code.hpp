// The same model with other code: what was made in the meantime takes the place of what the run began with.
//
// Every copy that linking made of a row of code is looked up among the rows as they were; programs, places, counters
// and the list stay as they are, since code of the same meaning changes none of them. Cost: the code of types, plus the
// interactions if there are compiled steps now.
#pragma once
#include <vector>

#include "bip/image.hpp"

namespace bip::rt {

struct CoreParts;

/// before: the image's rows of code as they were.
void take_new_code(CoreParts& core, const std::vector<Code>& before);

}  // namespace bip::rt
