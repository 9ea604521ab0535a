// From the tree of a parsed property to a formula; internal to compiler/verify/property.
#pragma once
#include "compiler/verify/property/formula.hpp"

namespace bip::verify {

/// Makes the formula of a parsed property of runs: the largest parts that speak of one state become its conditions,
/// words become `Until`, `Release` and `Next`. Equal conditions share a row. The error says which limit the property
/// exceeds.
[[nodiscard]] Result<Formula> make_formula(const Property& parsed);

}  // namespace bip::verify
