// Estimates from independent runs: mean, deviation, quantiles, intervals of confidence.
#pragma once
#include <cstdint>
#include <vector>

namespace bip::library {

struct Interval {
  double low = 0, high = 0;
};

/// Of the values that are defined (no NaN).
struct Estimate {
  std::uint64_t count = 0;
  double mean = 0;
  double deviation = 0;  // of the values, from the mean of `count` of them (n - 1)
  double least = 0, greatest = 0;
  std::vector<double> quantiles;  // as asked for: the least value that so large a share of the values does not exceed
  Interval mean_interval;         // Student's t: exact for normal values, else for many
};
/// `shares`: of quantiles, 0 to 1. `level`: confidence, such as 0.95. Sums in the order of the values. O(n log n).
[[nodiscard]] Estimate estimate(const std::vector<double>& values, const std::vector<double>& shares, double level);

/// The interval of a probability, when `successes` of `count` independent trials succeeded: it covers the truth at
/// least as often as `level` says (C. Clopper, E. Pearson, The Use of Confidence or Fiducial Limits Illustrated in the
/// Case of the Binomial, 1934).
[[nodiscard]] Interval clopper_pearson(std::uint64_t successes, std::uint64_t count, double level);

/// Runs that suffice to be within `error` of a probability with confidence `level`, whatever the probability is
/// (M. Okamoto, Some Inequalities Relating to the Partial Sum of Binomial Probabilities, 1958).
[[nodiscard]] std::uint64_t runs_for(double error, double level);

/// The regularized incomplete beta function I_x(a, b), 0 <= x <= 1, a, b > 0.
[[nodiscard]] double incomplete_beta(double a, double b, double x);

}  // namespace bip::library
