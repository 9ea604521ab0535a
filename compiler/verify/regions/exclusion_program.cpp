// See exclusion_program.hpp.
#include "compiler/verify/regions/exclusion_program.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "compiler/base/log.hpp"
#include "compiler/verify/counting/simplex.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr int kMostColourRounds = 60;         // of colour refinement
constexpr std::size_t kMostClassRows = 1200;  // of the program of the classes: the simplex method has a square of them
constexpr std::int64_t kMostRegionScale = 64;
constexpr double kShortOfAll = 1e-4;  // how much less than all components have a state, so that it is no rounding

std::uint64_t mixed_colour(std::uint64_t x) {  // splitmix64
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

// Numbers equal colours equally, in the order of their first occurrence.
std::vector<u32> numbered_colours(const std::vector<std::uint64_t>& colours, std::vector<u32>& representatives) {
  std::unordered_map<std::uint64_t, u32> number;
  std::vector<u32> result;
  representatives.clear();
  for (u32 row = 0; row < colours.size(); ++row) {
    const auto [found, is_new] = number.try_emplace(colours[row], static_cast<u32>(representatives.size()));
    if (is_new) representatives.push_back(row);
    result.push_back(found->second);
  }
  return result;
}

}  // namespace

u32 ExclusionProgram::add_component(u32 states) {
  const u32 first = size();
  first_.push_back(first);
  component_of_.insert(component_of_.end(), states, static_cast<u32>(first_.size() - 1));
  is_possible_.insert(is_possible_.end(), states, std::uint8_t{1});
  return first;
}

void ExclusionProgram::add(Implication implication) {
  BIP_ASSERT(std::is_sorted(implication.states.begin(), implication.states.end()), "states are not sorted");
  if (implication.states.empty()) return;
  if (!implication.implied.empty()) implication.other = component_of_[implication.implied.front()];
  implications_.push_back(std::move(implication));
}

void ExclusionProgram::forbid(u32 state, u32 source) {
  if (!is_possible(state)) return;
  is_possible_[state] = 0;
  const bool is_next = !forbidden_.empty() && forbidden_.back().source == source && forbidden_.back().others.empty() &&
                       component_of_[forbidden_.back().states.front()] == component_of_[state];
  if (is_next) forbidden_.back().states.push_back(state);
  else forbidden_.push_back({{state}, {}, source});
}

std::vector<u32> ExclusionProgram::impossible_states(u32 component) const {
  std::vector<u32> states;
  for (u32 state = first_[component]; state < end_of(component); ++state) {
    if (!is_possible(state)) states.push_back(state);
  }
  return states;
}

// States that imply nothing that is possible are impossible themselves. Afterwards implications are about possible
// states only, each once.
void ExclusionProgram::propagate() {
  forbid_by_implications();
  for (Implication& implication : implications_) shorten(implication);
  // What was true of all states of a component says now that others are impossible.
  forbid_by_implications();
  std::stable_sort(implications_.begin(), implications_.end());
  implications_.erase(std::unique(implications_.begin(), implications_.end()), implications_.end());
}

void ExclusionProgram::forbid_by_implications() {
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (Implication& implication : implications_) {
      std::erase_if(implication.implied, [&](u32 state) { return !is_possible(state); });
      std::erase_if(implication.states, [&](u32 state) { return !is_possible(state); });
      if (!implication.implied.empty() || implication.states.empty()) continue;
      Forbidden row{implication.states, {}, implication.source};
      if (implication.other != kNone) row.others = impossible_states(implication.other);
      forbidden_.push_back(std::move(row));
      for (const u32 state : implication.states) is_possible_[state] = 0;
      implication.states.clear();
      is_changed = true;
    }
    std::erase_if(implications_, [](const Implication& implication) { return implication.states.empty(); });
  }
}

// The possible states of the component of `states` that are not among these.
std::vector<u32> ExclusionProgram::others_than(const std::vector<u32>& states) const {
  const u32 component = component_of_[states.front()];
  std::vector<u32> others;
  for (u32 state = first_[component]; state < end_of(component); ++state) {
    if (is_possible(state) && !std::binary_search(states.begin(), states.end(), state)) others.push_back(state);
  }
  return others;
}

// "A implies B" is "what is not in B implies what is not in A", whichever has fewer states. Without states: it says
// nothing.
void ExclusionProgram::shorten(Implication& implication) const {
  std::vector<u32> not_implied = others_than(implication.implied);
  if (not_implied.empty()) {
    implication.states.clear();
    return;
  }
  std::vector<u32> others = others_than(implication.states);
  if (not_implied.size() + others.size() >= implication.states.size() + implication.implied.size()) return;
  implication.other = component_of_[implication.states.front()];
  implication.states = std::move(not_implied);
  implication.implied = std::move(others);
}

ExclusionProgram::Classes ExclusionProgram::find_classes() const {
  std::vector<std::uint64_t> state(size(), 1), component(first_.size(), 1), implication(implications_.size(), 1), sum;
  for (u32 row = 0; row < size(); ++row) {
    if (!is_possible(row)) state[row] = 0;
  }
  constexpr std::uint64_t kImplied = 0x5bd1e995u;
  Classes classes;
  std::size_t count = 0;
  for (int round = 0; round < kMostColourRounds; ++round) {
    std::fill(component.begin(), component.end(), 0);
    for (u32 row = 0; row < size(); ++row) {
      if (is_possible(row)) component[component_of_[row]] += mixed_colour(state[row]);
    }
    sum.assign(size(), 0);
    for (std::size_t row = 0; row < implications_.size(); ++row) {
      std::uint64_t colour = 0;
      for (const u32 each : implications_[row].states) colour += mixed_colour(state[each]);
      for (const u32 each : implications_[row].implied) colour += mixed_colour(state[each] ^ kImplied);
      implication[row] = colour;
      for (const u32 each : implications_[row].states) sum[each] += mixed_colour(colour);
      for (const u32 each : implications_[row].implied) sum[each] += mixed_colour(colour ^ kImplied);
    }
    for (u32 row = 0; row < size(); ++row) {
      if (is_possible(row))
        state[row] = mixed_colour(mixed_colour(state[row]) + sum[row]) ^ mixed_colour(component[component_of_[row]]);
    }
    classes.of_state = numbered_colours(state, classes.states);
    if (classes.states.size() == count) break;
    count = classes.states.size();
  }
  classes.of_component = numbered_colours(component, classes.components);
  classes.of_implication = numbered_colours(implication, classes.implications);
  classes.members.assign(classes.states.size(), 0);
  for (const u32 row : classes.of_state) ++classes.members[row];
  classes.implication_members.assign(classes.implications.size(), 0);
  for (const u32 row : classes.of_implication) ++classes.implication_members[row];
  return classes;
}

std::optional<ExclusionProgram::Proof> ExclusionProgram::refute(const CancellationToken& cancellation) {
  propagate();
  for (u32 component = 0; component < first_.size(); ++component) {
    bool has_state = false;
    for (u32 state = first_[component]; state < end_of(component) && !has_state; ++state)
      has_state = is_possible(state);
    if (!has_state) return Proof{{}, 1};
  }
  const Classes classes = find_classes();
  const std::size_t implications = classes.implications.size(), rows = implications + classes.components.size();
  BIP_LOG(Portfolio, 1, "exclusion program: {} states, {} implications; {} and {} classes, {} of components", size(),
          implications_.size(), classes.states.size(), implications, classes.components.size());
  if (rows > kMostClassRows || cancellation.is_over()) return std::nullopt;
  // Maximise how many components have a state; a component has at most one.
  LinearProgram program;
  program.bounds.assign(rows, 0);
  program.columns.resize(classes.states.size());
  for (std::size_t row = 0; row < classes.states.size(); ++row) {
    if (is_possible(classes.states[row])) program.columns[row].gain = static_cast<double>(classes.members[row]);
  }
  std::unordered_map<u32, double> changes;
  const auto add_row = [&](std::size_t row) {
    for (const auto& [column, change] : changes) {
      if (change != 0) program.columns[column].changes.emplace_back(static_cast<u32>(row), change);
    }
    changes.clear();
  };
  for (std::size_t row = 0; row < implications; ++row) {
    const Implication& one = implications_[classes.implications[row]];
    for (const u32 state : one.states) changes[classes.of_state[state]] -= 1;
    for (const u32 state : one.implied) changes[classes.of_state[state]] += 1;
    add_row(row);
  }
  for (std::size_t row = 0; row < classes.components.size(); ++row) {
    const u32 component = classes.components[row];
    for (u32 state = first_[component]; state < end_of(component); ++state) {
      if (is_possible(state)) changes[classes.of_state[state]] -= 1;
    }
    program.bounds[implications + row] = 1;
    add_row(implications + row);
  }
  const SimplexResult found = maximise(program, cancellation);
  if (found.end != SimplexEnd::Optimal || found.value > static_cast<double>(first_.size()) - kShortOfAll)
    return std::nullopt;
  std::vector<double> multipliers(implications_.size(), 0);
  for (std::size_t row = 0; row < implications_.size(); ++row) {
    const u32 of = classes.of_implication[row];
    multipliers[row] = std::max(0.0, found.multipliers[of]) / static_cast<double>(classes.implication_members[of]);
  }
  return round(multipliers);
}

// Multiples of the least multiplier, and of fractions of it.
std::optional<ExclusionProgram::Proof> ExclusionProgram::round(const std::vector<double>& multipliers) const {
  double least = std::numeric_limits<double>::infinity();
  for (const double each : multipliers) {
    if (each > kShortOfAll / static_cast<double>(std::max<std::size_t>(1, first_.size())))
      least = std::min(least, each);
  }
  if (least == std::numeric_limits<double>::infinity()) return std::nullopt;
  std::vector<std::int64_t> integers(multipliers.size());
  for (std::int64_t scale = 1; scale <= kMostRegionScale; scale = scale < 8 ? scale + 1 : scale * 2) {
    for (std::size_t row = 0; row < integers.size(); ++row)
      integers[row] = std::llround(std::min(multipliers[row] / least * static_cast<double>(scale), 1e9));
    const std::optional<std::int64_t> sum = least_sum(integers);
    if (!sum || *sum <= 0) continue;
    Proof proof;
    proof.least = *sum;
    for (std::size_t row = 0; row < integers.size(); ++row) {
      if (integers[row] == 0) continue;
      proof.used.push_back(implications_[row]);
      proof.used.back().multiplier = integers[row];
    }
    return proof;
  }
  return std::nullopt;
}

// Nothing: a number may overflow.
std::optional<std::int64_t> ExclusionProgram::least_sum(const std::vector<std::int64_t>& multipliers) const {
  std::vector<std::int64_t> weight(size(), 0);
  std::int64_t all = 0;
  for (std::size_t row = 0; row < multipliers.size(); ++row) {
    const std::int64_t multiplier = multipliers[row];
    BIP_ASSERT(multiplier >= 0, "a multiplier is {}", multiplier);
    if (__builtin_add_overflow(all, multiplier, &all)) return std::nullopt;
    for (const u32 state : implications_[row].states) weight[state] += multiplier;
    for (const u32 state : implications_[row].implied) weight[state] -= multiplier;
  }
  if (all > std::numeric_limits<std::int64_t>::max() / static_cast<std::int64_t>(2 * first_.size() + 2))
    return std::nullopt;
  std::vector<std::int64_t> least(first_.size(), std::numeric_limits<std::int64_t>::max());
  for (u32 state = 0; state < size(); ++state) {
    if (is_possible(state)) least[component_of_[state]] = std::min(least[component_of_[state]], weight[state]);
  }
  std::int64_t sum = 0;
  for (const std::int64_t each : least) sum += each;
  return sum;
}

}  // namespace bip::verify
