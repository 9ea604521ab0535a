// Robot modules and the rules over them, as rows for pictures (compiler/graph/module_graph.hpp).
#pragma once
#include <optional>
#include <string>

#include "compiler/driver/options.hpp"
#include "compiler/graph/module_graph.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::driver {

/// Is it a description of robot modules, or a .rules file, by its name?
[[nodiscard]] bool describes_modules(const std::string& file);

/// Reads descriptions, or one .rules file with the modules that it names. Nothing: there are errors.
[[nodiscard]] std::optional<graph::ModuleGraph> describe_modules(Compilation& c, const GenomArguments& arguments);

}  // namespace bip::driver
