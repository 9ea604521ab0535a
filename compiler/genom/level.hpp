// The functional level: all modules, the components shared by them, and the connectors that rules replace
// (compiler/docs/rules.md). Internal to compiler/genom.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"

namespace bip::genom {

/// The names that the functional level has of its own.
[[nodiscard]] Scope level_scope();
/// The atom through which C++ (or a client) asks for services, and the functions that it calls. `requests`: what may be
/// asked for.
[[nodiscard]] std::string executive_type(Executive executive, const std::vector<std::string>& requests);
/// Returns what may be asked for.
[[nodiscard]] std::vector<std::string> write_level(std::string& out, const std::vector<Plan>& plans,
                                                   const GenerateOptions& options, std::int64_t tick_us);

}  // namespace bip::genom
