// From the tree of a parsed property to a formula; internal to compiler/verify/property.
#pragma once
#include <optional>
#include "compiler/verify/property/formula.hpp"

namespace bip::verify {

/// Makes the formula of a parsed property of runs: the largest parts that speak of one state become its conditions,
/// words become `Until`, `Release` and `Next`. Equal conditions share a row. `is_temporal`: by node, whether it speaks
/// of runs. `within`: the limit of time of the root, which is `eventually` or `leads to`. The error says which limit
/// the property exceeds.
[[nodiscard]] Result<Formula> make_formula(const Property& parsed, const std::vector<std::uint8_t>& is_temporal,
                                           std::optional<std::int64_t> within);

}  // namespace bip::verify
