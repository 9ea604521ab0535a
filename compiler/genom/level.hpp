// The functional level: all modules, the components shared by them, and the connectors that rules replace
// (compiler/docs/rules.md). Internal to compiler/genom.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/mailbox.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"

namespace bip::genom {

/// The names that the functional level has of its own.
[[nodiscard]] Scope level_scope();
/// Returns what may be asked for, by module; nothing if all services may be requested.
[[nodiscard]] std::vector<std::vector<RequestSpec>> write_level(std::string& out, const std::vector<Plan>& plans,
                                                                const GenerateOptions& options, std::int64_t tick_us);

}  // namespace bip::genom
