// Probabilities of rare events by importance splitting with fixed effort (M. Garvels, The splitting method in rare
// event simulation, 2000).
//
// An importance function says how near to the goal a state is. Its levels are thresholds: a run is rare because it has
// to climb all of them. At each level the same number of runs begins, each in a state in which an earlier one climbed
// it, and goes on until it climbs the next level, is answered or ends. The product of the shares that climb is an
// unbiased estimate of the probability. Independent replications say how far it is from the truth.
//
// Runs that begin in one state differ by their seeds; the policy has no memory. Results depend on the seed alone, not
// on the number of threads. Cost: replications * levels * effort * steps to the next level or to an end.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "bip/run.hpp"
#include "runtime/engine/path_query.hpp"

namespace bip::rt {

struct SplittingOptions {
  PathQuery query;                                // not negated
  std::function<double(const Core&)> importance;  // of a state
  std::vector<double> levels;                     // ascending; empty: found by trial runs, each climbed by about 1 in 5
  std::uint64_t effort = 1000;                    // runs a level
  std::uint64_t replications = 32;
  std::uint64_t seed = 0;
  std::uint64_t limit = 1'000'000;  // steps of a run, from the initial state on
  u32 threads = 1;
  bool asap = false;
  MaximalProgress progress = MaximalProgress::On;
  std::function<bool()> is_stopped;
};
struct SplittingReport {
  bool is_complete = true;
  std::vector<double> levels;     // that were used
  std::vector<double> estimates;  // by replication
  std::uint64_t steps = 0;
  std::uint64_t open = 0;  // runs that ended at `limit`
  std::string fault;       // of the first run that ended so; then there are no estimates
};
/// Requires an image without C++, with its code.
[[nodiscard]] SplittingReport split(const Image& image, const SplittingOptions& options);

}  // namespace bip::rt
