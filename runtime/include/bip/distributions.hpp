// The distributions of package std.chance: their names, parameters and what their arguments must be. How numbers are
// drawn: draws.hpp.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

namespace bip::rt {

/// A distribution. `params` has a letter for each argument: i int, f float; `result` also b bool.
struct ProbabilityDistribution {
  const char* name;
  const char* params;
  char result;
  const char* function;  // of draws.hpp
};
/// Several may have one name.
inline constexpr ProbabilityDistribution kDistributions[] = {
    {"uniform", "ii", 'i', "draw_uniform_int"},
    {"uniform", "ff", 'f', "draw_uniform_float"},
    {"normal", "ff", 'f', "draw_normal"},
    {"normal", "ffff", 'f', "draw_truncated_normal"},
    {"exponential", "f", 'f', "draw_exponential"},
    {"flip", "f", 'b', "draw_flip"},
    {"table", "ifif", 'i', "draw_table2"},
    {"table", "ififif", 'i', "draw_table3"},
    {"table", "ifififif", 'i', "draw_table4"},
    {"table", "ififififif", 'i', "draw_table5"},
    {"table", "ifififififif", 'i', "draw_table6"},
    {"table", "ififififififif", 'i', "draw_table7"},
    {"table", "ifififififififif", 'i', "draw_table8"},
};
inline constexpr std::size_t kMostDrawArguments = 16;

/// The distribution with this name, these parameters and this result; null: there is none.
constexpr const ProbabilityDistribution* find_distribution(std::string_view name, std::string_view params,
                                                           char result) {
  for (const ProbabilityDistribution& row : kDistributions) {
    if (row.name == name && row.params == params && row.result == result) return &row;
  }
  return nullptr;
}

namespace distributions {
constexpr bool is_finite(double value) {
  return value >= -std::numeric_limits<double>::max() && value <= std::numeric_limits<double>::max();
}
constexpr const char* table_problem(const double* args, std::size_t rows) {
  double sum = 0;
  for (std::size_t k = 0; k < rows; ++k) {
    const double weight = args[2 * k + 1];
    if (!(weight >= 0) || !is_finite(weight)) return "a weight is negative or not finite";
    sum += weight;
  }
  if (!is_finite(sum)) return "the sum of the weights is not finite";
  return sum > 0 ? nullptr : "all weights are 0";
}
}  // namespace distributions

/// Returns what is wrong with arguments, such as "low is above high"; null: nothing. Ints are given as doubles, which
/// hold them exactly.
constexpr const char* argument_problem(const ProbabilityDistribution& distribution, const double* args) {
  using distributions::is_finite;
  const std::string_view name = distribution.name, params = distribution.params;
  if (name == "table") return distributions::table_problem(args, params.size() / 2);
  if (name == "flip") return args[0] >= 0 && args[0] <= 1 ? nullptr : "the probability is not between 0 and 1";
  if (name == "exponential") return args[0] > 0 && is_finite(args[0]) ? nullptr : "the mean is not above 0";
  if (name == "uniform") {
    if (!is_finite(args[0]) || !is_finite(args[1])) return "an end is not finite";
    return args[0] <= args[1] ? nullptr : "low is above high";
  }
  if (!is_finite(args[0])) return "the mean is not finite";
  if (!(args[1] > 0) || !is_finite(args[1])) return "the standard deviation is not above 0";
  if (params.size() == 2) return nullptr;
  if (!is_finite(args[2]) || !is_finite(args[3])) return "an end is not finite";
  return args[2] < args[3] ? nullptr : "low is not below high";
}

}  // namespace bip::rt
