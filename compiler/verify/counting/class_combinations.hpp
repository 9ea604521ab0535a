// Combinations of classes of local states, one class a component; those that differ in one component are joined.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace bip::verify {

/// By component the classes that are meant, ascending: one combination, or all of several that were joined.
using ClassCombination = std::vector<std::vector<std::uint32_t>>;

/// Joins combinations that agree in all components but this one. Cost: O(n log n) comparisons of combinations.
inline void join_combinations(std::vector<ClassCombination>& combinations, std::size_t component) {
  std::map<ClassCombination, std::vector<std::uint32_t>> joined;
  for (ClassCombination& combination : combinations) {
    std::vector<std::uint32_t> classes = std::move(combination[component]);
    combination[component].clear();
    std::vector<std::uint32_t>& all = joined[combination];
    all.insert(all.end(), classes.begin(), classes.end());
  }
  combinations.clear();
  for (auto& [combination, classes] : joined) {
    std::sort(classes.begin(), classes.end());
    combinations.push_back(combination);
    combinations.back()[component] = std::move(classes);
  }
}

}  // namespace bip::verify
