// The C++ functions of the execution flavour; generate_package.hpp declares the functions that return their header and
// source. Internal to compiler/genom.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/constraints.hpp"
#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/module.hpp"

namespace bip::genom {

/// `extern function` lines of all codels, and of what tells the values of posters.
[[nodiscard]] std::string codel_prototypes(const std::vector<Module>& modules, const GenerateOptions& options);
/// The function that tells a value when its poster is written: MODULE_POSTER_VALUE.
[[nodiscard]] std::string value_function(const std::vector<Module>& modules, const ValueRow& value);
[[nodiscard]] std::string value_function(const Module& module, const ValueRow& value);

}  // namespace bip::genom
