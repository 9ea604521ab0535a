// What many runs say of one observer: shared by `bipc simulate` and `bip::compiler`.
#pragma once
#include <vector>

#include "compiler/library/estimate.hpp"
#include "runtime/engine/simulate.hpp"

namespace bip::library {

inline constexpr double kConfidence = 0.95;

struct ObserverEstimate {
  Estimate values;    // quantiles: 5%, 50% and 95%
  Interval interval;  // of the mean with that confidence; of a probability that of Clopper and Pearson
};
/// `values`: by run, NaN where the observer is undefined. O(n log n).
[[nodiscard]] ObserverEstimate estimate_of(const rt::Observer& observer, const std::vector<double>& values,
                                           double confidence = kConfidence);

/// Bytes that the results of one run need.
[[nodiscard]] std::uint64_t bytes_of_run(const rt::SimulateOptions& options);

}  // namespace bip::library
