// Random runs: each step is one of all that are possible, with equal probability. They find what is easy to run into
// and far away, which a search of all states meets late; they prove nothing.
#pragma once
#include "compiler/verify/portfolio/search_bad_state.hpp"

namespace bip::verify {

struct RandomRunLimits {
  CancellationToken cancellation;
  // Counts, so that an answer does not depend on the machine.
  std::uint64_t runs = 64, steps = 10'000;
};

/// Ends with Found, replayed from the initial state, or Limit. The image must have its code. Cost: a step of the core
/// each.
[[nodiscard]] SearchResult run_at_random(const rt::Image& image, const SearchGoal& goal, const RandomRunLimits& limits);

}  // namespace bip::verify
