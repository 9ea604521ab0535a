// How often each interaction was taken in an earlier run: what a placement without a home for each component goes by.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::driver {

/// The path of the interaction's connector, or `atom.port`.
[[nodiscard]] std::string interaction_name(const rt::Tables& tables, rt::InteractionId interaction);

/// Reads the bytes of a binary trace, or of a profile (`--profile-json`), which counts the interactions of each
/// declaration: each of them gets the same share. Returns a number for each interaction, in proportion to how often it
/// was taken.
[[nodiscard]] Result<std::vector<std::uint64_t>> read_counts(const rt::Tables& tables, const std::string& bytes);

}  // namespace bip::driver
