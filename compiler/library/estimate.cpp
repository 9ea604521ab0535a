// See estimate.hpp. Inverses by bisection: 200 halvings reach the last bit of a double.
#include "compiler/library/estimate.hpp"

#include <algorithm>
#include <cmath>

#include "runtime/include/bip/assert.hpp"

namespace bip::library {
namespace {

constexpr int kHalvings = 200;

/// The x from low to high where the rising function `of` reaches `wanted`.
template <class Function>
double inverse(double low, double high, double wanted, Function&& of) {
  BIP_ASSERT(low <= high, "between {} and {}", low, high);
  for (int k = 0; k < kHalvings && low < high; ++k) {
    const double middle = low + (high - low) / 2;
    (of(middle) < wanted ? low : high) = middle;
  }
  return low + (high - low) / 2;
}

/// The t that Student's distribution with that many degrees of freedom exceeds with probability `tail` < 0.5.
double student_quantile(double freedom, double tail) {
  constexpr double kFar = 1e6;
  return inverse(0, kFar, 1 - tail,
                 [&](double t) { return 1 - incomplete_beta(freedom / 2, 0.5, freedom / (freedom + t * t)) / 2; });
}

}  // namespace

// The continued fraction of NIST's Digital Library of Mathematical Functions, 8.17.22, by Lentz's method; on the side
// of the mean where it converges fast.
double incomplete_beta(double a, double b, double x) {
  BIP_ASSERT(a > 0 && b > 0 && x >= 0 && x <= 1, "I_{}({}, {})", x, a, b);
  if (x == 0 || x == 1) return x;
  if (x > (a + 1) / (a + b + 2)) return 1 - incomplete_beta(b, a, 1 - x);
  constexpr double kTiny = 1e-300, kPrecise = 1e-16;
  constexpr int kMostTerms = 100000;
  const auto away_from_zero = [](double value) { return std::fabs(value) < kTiny ? kTiny : value; };
  double numerator = 1, denominator = 1 / away_from_zero(1 - (a + b) * x / (a + 1));
  double fraction = denominator;
  for (int m = 1; m < kMostTerms; ++m) {
    const double k = m;
    const double even = k * (b - k) * x / ((a + 2 * k - 1) * (a + 2 * k));
    denominator = 1 / away_from_zero(1 + even * denominator);
    numerator = away_from_zero(1 + even / numerator);
    fraction *= denominator * numerator;
    const double odd = -(a + k) * (a + b + k) * x / ((a + 2 * k) * (a + 2 * k + 1));
    denominator = 1 / away_from_zero(1 + odd * denominator);
    numerator = away_from_zero(1 + odd / numerator);
    const double change = denominator * numerator;
    fraction *= change;
    if (std::fabs(change - 1) < kPrecise) break;
  }
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  return front * fraction / a;
}

Interval clopper_pearson(std::uint64_t successes, std::uint64_t count, double level) {
  BIP_ASSERT(successes <= count && level > 0 && level < 1, "{} of {} at {}", successes, count, level);
  if (count == 0) return {0, 1};
  const double tail = (1 - level) / 2;
  const auto yes = static_cast<double>(successes), no = static_cast<double>(count - successes);
  Interval interval{0, 1};
  if (successes != 0) interval.low = inverse(0, 1, tail, [&](double p) { return incomplete_beta(yes, no + 1, p); });
  if (successes != count)
    interval.high = inverse(0, 1, 1 - tail, [&](double p) { return incomplete_beta(yes + 1, no, p); });
  return interval;
}

std::uint64_t runs_for(double error, double level) {
  BIP_ASSERT(error > 0 && level > 0 && level < 1, "within {} at {}", error, level);
  return static_cast<std::uint64_t>(std::ceil(std::log(2 / (1 - level)) / (2 * error * error)));
}

Estimate estimate(const std::vector<double>& values, const std::vector<double>& shares, double level) {
  Estimate out;
  std::vector<double> defined;
  defined.reserve(values.size());
  std::copy_if(values.begin(), values.end(), std::back_inserter(defined), [](double v) { return !std::isnan(v); });
  out.count = defined.size();
  out.quantiles.assign(shares.size(), std::nan(""));
  if (defined.empty()) return out;
  // Welford's recurrence (1962): no difference of large sums.
  double squares = 0, number = 0;
  for (const double value : defined) {
    number += 1;
    const double before = value - out.mean;
    out.mean += before / number;
    squares += before * (value - out.mean);
  }
  out.deviation = number > 1 ? std::sqrt(squares / (number - 1)) : 0;
  const double half =
      number > 1 ? student_quantile(number - 1, (1 - level) / 2) * out.deviation / std::sqrt(number) : 0;
  out.mean_interval = {out.mean - half, out.mean + half};
  std::sort(defined.begin(), defined.end());
  out.least = defined.front();
  out.greatest = defined.back();
  BIP_ASSERT(out.count <= values.size() && !(out.deviation < 0) && out.least <= out.greatest,
             "{} of {} values from {} to {}", out.count, values.size(), out.least, out.greatest);
  for (std::size_t k = 0; k < shares.size(); ++k) {
    const double rank = std::ceil(shares[k] * number);
    out.quantiles[k] = defined[static_cast<std::size_t>(std::clamp(rank, 1.0, number)) - 1];
  }
  return out;
}

}  // namespace bip::library
