// Can two guards of one component hold in the same state?
#pragma once
#include "compiler/model/code.hpp"
#include "compiler/model/time.hpp"

namespace bip {

/// Returns true only if no values of the variables make both guards true, as their text shows: `n > 1` and `n == 1`,
/// `n < most` and `n >= most`, `is_on && g` and `!is_on`. An invalid guard is true. Both read the variables of one
/// owner. Cost: the product of the guards' sizes; guards with many alternatives are not looked at.
[[nodiscard]] bool are_exclusive(const CodeTable& code, ExprId first, ExprId second);

/// Returns true only if constants alone say that the two never hold together: no value of some clock, or difference of
/// clocks, satisfies the bounds of both. Time is dense: there is an instant between two ticks. Cost: quadratic.
[[nodiscard]] bool are_exclusive(const TimeGuard& first, const TimeGuard& second);

}  // namespace bip
