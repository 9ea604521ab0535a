// Prints the profile of a run (runtime/core/profile.hpp) with the names of the model, as tables or as JSON.
#pragma once
#include <cstdint>
#include <string>

#include "compiler/lower/lower.hpp"
#include "runtime/core/profile.hpp"

namespace bip::driver {

/// Interactions, types and pieces of code, each sorted by its share of the run; the first few of each.
[[nodiscard]] std::string profile_text(const lower::LoweredSystem& lowered, const rt::Profile& profile,
                                       std::uint64_t steps);

/// One object with all rows, a line.
[[nodiscard]] std::string profile_json(const lower::LoweredSystem& lowered, const rt::Profile& profile,
                                       std::uint64_t steps);

}  // namespace bip::driver
