// The C++ side of the execution flavour. Inside compiler/genom only; its header and source are asked for in generate.hpp.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/module.hpp"

namespace bip::genom {

/// `extern function` lines of all codels.
[[nodiscard]] std::string codel_prototypes(const std::vector<Module>& modules);

}  // namespace bip::genom
