// Proofs by regions as rows of a certificate: `lemma` rows say in which local states a component can be; `unless` rows
// are the implications of the linear program, with their multipliers, and why single states are impossible.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/verify/regions/bad_regions.hpp"
#include "compiler/verify/regions/exclusion_program.hpp"

namespace bip::verify {

/// Returns what these components can be in, each by itself.
[[nodiscard]] std::string local_state_rows(const RegionNet& net, const RegionSpaces& spaces,
                                           const std::vector<u32>& atoms);

/// Returns the rows of a proof that no state is without a step, where all sources of the program are rows of
/// connectors, or steps of ports alone (bad_regions.hpp). Nothing: the proof rests on something else, or weights are
/// too large for the checker.
[[nodiscard]] std::optional<std::string> deadlock_rows(const RegionNet& net, const RegionSpaces& spaces,
                                                       const ExclusionProgram& program,
                                                       const ExclusionProgram::Proof& proof);

}  // namespace bip::verify
