// Estimates of `bipc simulate` against known values.
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "compiler/library/estimate.hpp"

namespace bip::library {
namespace {

bool is_near(double a, double b, double within) { return std::fabs(a - b) <= within; }

}  // namespace

TEST_CASE("the incomplete beta function agrees with closed forms") {
  for (const double x : {0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0}) {
    CHECK(is_near(incomplete_beta(1, 1, x), x, 1e-14));
    CHECK(is_near(incomplete_beta(2, 1, x), x * x, 1e-14));
    CHECK(is_near(incomplete_beta(1, 3, x), 1 - std::pow(1 - x, 3), 1e-14));
    CHECK(is_near(incomplete_beta(0.5, 0.5, x), 2 / std::acos(-1.0) * std::asin(std::sqrt(x)), 1e-13));
    CHECK(is_near(incomplete_beta(30, 50, x), 1 - incomplete_beta(50, 30, 1 - x), 1e-13));
  }
}

TEST_CASE("Clopper-Pearson intervals are those of the tables") {
  const Interval none = clopper_pearson(0, 10, 0.95), half = clopper_pearson(5, 10, 0.95);
  CHECK(none.low == 0);
  CHECK(is_near(none.high, 1 - std::pow(0.025, 0.1), 1e-12));
  CHECK(is_near(half.low, 0.187086, 1e-6));
  CHECK(is_near(half.high, 0.812914, 1e-6));
  const Interval rare = clopper_pearson(1, 20, 0.95), all = clopper_pearson(7, 7, 0.99);
  CHECK(is_near(rare.low, 0.001265, 1e-6));
  CHECK(is_near(rare.high, 0.248733, 1e-6));
  CHECK(all.high == 1);
  CHECK(is_near(all.low, std::pow(0.005, 1.0 / 7), 1e-12));
  const Interval nothing = clopper_pearson(0, 0, 0.95);
  CHECK(nothing.low == 0);
  CHECK(nothing.high == 1);
}

TEST_CASE("Clopper-Pearson intervals cover the truth as often as they say") {
  // Exactly: the probability of all outcomes whose interval holds p.
  for (const double p : {0.01, 0.2, 0.5, 0.93}) {
    double covered = 0;
    constexpr std::uint64_t kTrials = 40;
    for (std::uint64_t k = 0; k <= kTrials; ++k) {
      const Interval interval = clopper_pearson(k, kTrials, 0.9);
      const double choose = std::lgamma(kTrials + 1.0) - std::lgamma(static_cast<double>(k) + 1.0) -
                            std::lgamma(static_cast<double>(kTrials - k) + 1.0);
      const double probability =
          std::exp(choose + static_cast<double>(k) * std::log(p) + static_cast<double>(kTrials - k) * std::log1p(-p));
      if (interval.low <= p && p <= interval.high) covered += probability;
    }
    CHECK(covered >= 0.9);
  }
}

TEST_CASE("an estimate leaves undefined values out") {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const Estimate of = estimate({5, none, 1, 4, 2, none, 3}, {0.2, 0.5, 1}, 0.95);
  CHECK(of.count == 5);
  CHECK(is_near(of.mean, 3, 1e-15));
  CHECK(is_near(of.deviation, std::sqrt(2.5), 1e-15));
  CHECK(of.least == 1);
  CHECK(of.greatest == 5);
  CHECK(of.quantiles == std::vector<double>{1, 3, 5});
  // Student's t with 4 degrees of freedom: 2.776445.
  CHECK(is_near(of.mean_interval.high, 3 + 2.776445 * std::sqrt(2.5 / 5), 1e-6));
  CHECK(estimate({none}, {0.5}, 0.95).count == 0);
  CHECK(estimate({7}, {0.5}, 0.95).deviation == 0);
}

TEST_CASE("Okamoto's number of runs") {
  CHECK(runs_for(0.01, 0.95) == 18445);
  CHECK(runs_for(0.1, 0.99) == 265);
}

}  // namespace bip::library
