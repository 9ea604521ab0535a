// The explorer's oracle: breadth first with nothing but a core and a map of whole states.
#pragma once
#include <map>
#include <vector>

#include "runtime/core/core.hpp"

namespace bip::rt::testing {

struct Naive {
  std::uint64_t states = 0, steps = 0, deadlocks = 0, errors = 0;
  std::uint32_t depth = 0;
  bool is_complete = true, initial_fault = false;
  std::vector<std::uint64_t> deadlock, error;  // the ways to the first ones
  bool has_error_way = false;
  std::vector<State> all;
};

inline Naive explore_naively(const Image& image, MaximalProgress progress, std::uint64_t limit) {
  using Key = std::tuple<std::vector<u32>, std::vector<u64>, std::vector<u64>>;
  struct Origin {
    std::size_t parent;
    std::uint64_t candidate;
    std::uint32_t depth;
  };
  Naive found;
  Core core(image, {.progress = progress});
  if (!core.initialize()) {
    found.errors = 1;
    found.initial_fault = true;
    return found;
  }
  std::map<Key, std::size_t> rows;
  std::vector<Origin> origins;
  const auto add = [&](std::size_t parent, std::uint64_t candidate) {
    State state = core.snapshot();
    const Key key{state.places, state.marks, state.data};
    if (rows.count(key) != 0) return true;
    if (rows.size() >= limit) return false;
    rows.emplace(key, rows.size());
    origins.push_back({parent, candidate, origins.empty() ? 0 : origins[parent].depth + 1});
    found.all.push_back(std::move(state));
    return true;
  };
  const auto way_to = [&](std::size_t row) {
    std::vector<std::uint64_t> way;
    for (; row != 0; row = origins[row].parent) way.insert(way.begin(), origins[row].candidate);
    return way;
  };
  (void)add(0, 0);
  for (std::size_t row = 0; row < found.all.size() && found.is_complete; ++row) {
    (void)core.restore(found.all[row]);
    found.depth = origins[row].depth;
    const std::uint64_t count = core.candidate_count();
    if (count == 0 && found.deadlocks++ == 0) found.deadlock = way_to(row);
    bool has_error = false;
    for (std::uint64_t k = 0; k < count && found.is_complete; ++k) {
      if (k != 0) (void)core.restore(found.all[row]);
      if (!core.fire(k)) {
        if (!found.has_error_way) {
          found.has_error_way = true;
          found.error = way_to(row);
          found.error.push_back(k);
        }
        found.errors += has_error ? 0 : 1;
        has_error = true;
      } else if (add(row, k)) {
        ++found.steps;
      } else {
        found.is_complete = false;
      }
    }
  }
  found.states = found.all.size();
  return found;
}

}  // namespace bip::rt::testing
