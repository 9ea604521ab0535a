// See observer_estimate.hpp.
#include "compiler/library/observer_estimate.hpp"

#include <cmath>

#include "runtime/include/bip/assert.hpp"

namespace bip::library {

ObserverEstimate estimate_of(const rt::Observer& observer, const std::vector<double>& values, double confidence) {
  ObserverEstimate made;
  made.values = estimate(values, {0.05, 0.5, 0.95}, confidence);
  made.interval = made.values.mean_interval;
  if (observer.kind == rt::ObserverKind::Reaches) {
    const auto trials = static_cast<double>(made.values.count);
    const auto successes = static_cast<std::uint64_t>(std::llround(made.values.mean * trials));
    BIP_ASSERT(successes <= made.values.count, "{} of {} runs reach it", successes, made.values.count);
    made.interval = clopper_pearson(successes, made.values.count, confidence);
  }
  return made;
}

std::uint64_t bytes_of_run(const rt::SimulateOptions& options) {
  return (options.observers.size() + 4) * sizeof(double);
}

}  // namespace bip::library
