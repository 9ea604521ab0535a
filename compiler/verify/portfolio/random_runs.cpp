// See random_runs.hpp.
#include "compiler/verify/portfolio/random_runs.hpp"

#include "runtime/include/bip/prng.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::uint64_t kStepsBetweenLooks = 256;  // at the clock

}  // namespace

SearchResult run_at_random(const rt::Image& image, const SearchGoal& goal, const RandomRunLimits& limits) {
  SearchResult result;
  result.limit = "random runs";
  rt::Core core(image);
  for (std::uint64_t run = 1; run <= limits.runs; ++run) {
    rt::Prng prng(run);
    result.choices.clear();
    bool goes_on = core.initialize();
    while (goes_on && !is_goal_state(core, goal)) {
      const std::uint64_t count = core.candidate_count();
      if (count == 0 || result.choices.size() == limits.steps) break;
      if (result.choices.size() % kStepsBetweenLooks == 0 && limits.cancellation.is_over()) return result;
      result.choices.push_back(prng.below(count));
      goes_on = core.fire(result.choices.back());
    }
    if (!goes_on && result.fault.empty()) result.fault = core.fault().what;
    const bool is_found = goes_on ? is_goal_state(core, goal) : goal.faults;
    BIP_ASSERT(result.choices.size() <= limits.steps, "run {} has {} steps of {}", run, result.choices.size(),
               limits.steps);
    if (!is_found || !reaches(image, goal, result.choices)) continue;
    result.end = SearchEnd::Found;
    return result;
  }
  return result;
}

}  // namespace bip::verify
