// Draws of random numbers: functions of package std.chance, which the compiler knows.
#pragma once
#include "compiler/model/code.hpp"
#include "runtime/include/bip/distributions.hpp"

namespace bip::model {

/// The package that declares the distributions.
inline constexpr std::string_view kChancePackage = "std.chance";

/// Returns the distribution that a function of kind Draw is; null: its name and types are those of none.
[[nodiscard]] const rt::ProbabilityDistribution* distribution_of(const Function& function);

/// Returns what is wrong with the arguments of a draw as far as they are constants, or null.
[[nodiscard]] const char* constant_argument_problem(const CodeTable& code, const Expr& draw);

/// Does the distribution take the arguments for sure: constants, and any ints as the values of a table?
[[nodiscard]] bool has_good_constants(const CodeTable& code, const Expr& draw);

}  // namespace bip::model
