// Finds the root compound of a file, and names the root in traces.
#pragma once
#include <string>
#include <vector>

#include "compiler/pipeline/pipeline.hpp"

namespace bip::pipeline {

/// The parameterless compounds that nothing in the file instantiates, in source order.
[[nodiscard]] std::vector<std::string> root_candidates(const Model& model);

/// "Ring(10)": the type with the arguments as written; "Ring()" without.
[[nodiscard]] std::string name_of_root(const Compilation& c);

}  // namespace bip::pipeline
