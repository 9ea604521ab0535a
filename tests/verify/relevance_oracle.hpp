// What relevant_steps and deciding_step return, looked at again by plain means: the graph of all states, each pair of
// states that reach each other, each single step left out.
#pragma once
#include <string>

#include "compiler/verify/portfolio/search_bad_state.hpp"

namespace bip::verify::test {

struct RelevanceCounts {
  std::uint64_t runs = 0, left_out = 0, decided = 0, inevitable = 0;
};
/// Walks at random to the goal, and compares what is said of that run. Returns what is wrong; empty: nothing, or there
/// are more than `states` states, or no walk met the goal.
[[nodiscard]] std::string check_relevance(const rt::Image& image, const SearchGoal& goal, std::uint64_t seed,
                                          std::size_t states, RelevanceCounts& counts);

}  // namespace bip::verify::test
