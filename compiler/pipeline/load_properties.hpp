// A file of properties: `property NAME { … }`, any number of them, with comments, paths from the root compound.
#pragma once
#include <string>

#include "compiler/pipeline/pipeline.hpp"

namespace bip::pipeline {

/// Adds the properties of the file to those of c.system, which must be there. False: reported, with the place.
[[nodiscard]] bool load_properties(Compilation& c, const std::string& path);

}  // namespace bip::pipeline
