// The explorer's oracle: breadth first with nothing but a core and a map of whole states.
#pragma once
#include <map>
#include <vector>

#include "runtime/core/core.hpp"

namespace bip::rt::testing {

struct Naive {
  std::uint64_t states = 0, steps = 0, deadlocks = 0, finals = 0, errors = 0;
  std::uint32_t depth = 0;
  bool is_complete = true, initial_fault = false;
  std::vector<std::uint64_t> deadlock, error;  // the ways to the first ones
  bool has_error_way = false;
  std::vector<State> all;
  std::vector<std::pair<std::size_t, std::uint64_t>> origins;  // by state: the one before, the candidate taken

  [[nodiscard]] std::vector<std::uint64_t> way_to(std::size_t row) const {
    std::vector<std::uint64_t> way;
    for (; row != 0; row = origins[row].first) way.insert(way.begin(), origins[row].second);
    return way;
  }
};

inline bool has_only_final_marks(const Core& core) {
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    const AtomType& type = core.image().atom_types[core.image().atoms[atom].type];
    for (u32 place = 0; place < type.places.size; ++place) {
      bool is_listed = false;
      for (const u32 final : type.final_places) is_listed = is_listed || final == place;
      if (core.is_marked(atom, place) && !is_listed) return false;
    }
  }
  return true;
}

inline Naive explore_naively(const Image& image, MaximalProgress progress, std::uint64_t limit) {
  using Key = std::tuple<std::vector<u32>, std::vector<u64>, std::vector<u64>>;
  Naive found;
  Core core(image, {.progress = progress});
  if (!core.initialize()) {
    found.errors = 1;
    found.initial_fault = true;
    return found;
  }
  std::map<Key, std::size_t> rows;
  std::vector<std::uint32_t> depths;
  const auto add = [&](std::size_t parent, std::uint64_t candidate) {
    State state = core.snapshot();
    const Key key{state.places, state.marks, state.data.rows()};
    if (rows.count(key) != 0) return true;
    if (rows.size() >= limit) return false;
    rows.emplace(key, rows.size());
    depths.push_back(depths.empty() ? 0 : depths[parent] + 1);
    found.origins.emplace_back(parent, candidate);
    found.all.push_back(std::move(state));
    return true;
  };
  (void)add(0, 0);
  for (std::size_t row = 0; row < found.all.size() && found.is_complete; ++row) {
    (void)core.restore(found.all[row]);
    found.depth = depths[row];
    const std::uint64_t count = core.candidate_count();
    const bool is_final = count == 0 && has_only_final_marks(core);
    found.finals += is_final ? 1 : 0;
    if (count == 0 && !is_final && found.deadlocks++ == 0) found.deadlock = found.way_to(row);
    bool has_error = false;
    for (std::uint64_t k = 0; k < count && found.is_complete; ++k) {
      if (k != 0) (void)core.restore(found.all[row]);
      if (!core.fire(k)) {
        if (!found.has_error_way) {
          found.has_error_way = true;
          found.error = found.way_to(row);
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
