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

/// Bytes of the property's text.
struct TextExtent {
  std::size_t begin = 0, end = 0;
};
/// Makes the formula of a parsed property that has the word `possibly`. `extents`: by node, the text of a temporal
/// operator with its operands. The error says with its column what CTL does not have.
[[nodiscard]] Result<BranchingFormula> make_branching(const Property& parsed,
                                                      const std::vector<std::uint8_t>& is_temporal,
                                                      const std::vector<TextExtent>& extents);

}  // namespace bip::verify
