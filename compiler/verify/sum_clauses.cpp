// See sum_clauses.hpp.
#include "compiler/verify/sum_clauses.hpp"

#include <algorithm>
#include <map>

namespace bip::verify {

// Of `count` things all choices of `size`, in order.
template <class Visit>
void SumClauses::each_subset(std::size_t count, std::size_t size, const Visit& visit) {
  std::vector<std::size_t> chosen(size);
  for (std::size_t k = 0; k < size; ++k) chosen[k] = k;
  while (visit(chosen)) {
    std::size_t k = size;
    while (k > 0 && chosen[k - 1] == count - size + k - 1) --k;
    if (k == 0) return;
    ++chosen[k - 1];
    for (; k < size; ++k) chosen[k] = chosen[k - 1] + 1;
  }
}

double SumClauses::Side::clauses() const {
  double count = 1;
  const auto all = static_cast<double>(good.size());
  for (std::int64_t k = 1; k < least; ++k) count *= (all - static_cast<double>(k) + 1) / static_cast<double>(k);
  return count;
}

std::optional<std::pair<SumClauses::Side, SumClauses::Side>> SumClauses::sides(const TokenInvariant& invariant) const {
  std::pair<Side, Side> result;
  Side& at_least = result.first;
  std::int64_t total = invariant.total, step = 0;
  for (std::size_t k = 0; k < invariant.modes.size();) {
    const u32 atom = net_.atom_of_mode[invariant.modes[k]];
    std::map<std::int64_t, std::vector<u32>> by_weight;
    for (u32 mode = net_.mode_base[atom]; mode < net_.mode_base[atom + 1]; ++mode) {
      const bool is_in = k < invariant.modes.size() && invariant.modes[k] == mode;
      if (reachable_[mode] != 0) by_weight[is_in ? weight_of(invariant, k) : 0].push_back(mode);
      if (is_in) ++k;
    }
    if (by_weight.empty() || by_weight.size() > 2) return std::nullopt;
    total -= by_weight.begin()->first;
    if (by_weight.size() == 1) continue;
    const std::int64_t here = by_weight.rbegin()->first - by_weight.begin()->first;
    if (step != 0 && step != here) return std::nullopt;
    step = here;
    at_least.good.push_back(std::move(by_weight.rbegin()->second));
    at_least.bad.push_back(std::move(by_weight.begin()->second));
  }
  if (step == 0 || total % step != 0 || total < 0 || total / step > static_cast<std::int64_t>(at_least.good.size())) return std::nullopt;
  at_least.least = total / step;
  result.second = {at_least.bad, at_least.good, static_cast<std::int64_t>(at_least.good.size()) - at_least.least};
  // Of a trap nothing is said of the most.
  if (invariant.kind == InvariantKind::Trap) result.second.least = 0;
  return result;
}

// "Is in a good mode", as clauses that all hold. At one place at most values decide, and there one value.
std::optional<std::vector<SumClauses::Clause>> SumClauses::told(const std::vector<u32>& good, const std::vector<u32>& bad) const {
  const u32 atom = net_.atom_of_mode[good[0]];
  const ModeClass& row = net_.class_at(atom);
  const Atom& instance = net_.system->atoms[AtomId(std::size_t{atom})];
  const AtomType& type = net_.system->atom_types[row.type];
  const auto mode_of = [&](u32 mode) -> const Mode& { return row.modes[mode - net_.mode_base[atom]]; };
  std::map<u32, std::pair<std::vector<u32>, std::vector<u32>>> places;  // good, bad
  for (u32 mode : good) {
    if (mode_of(mode).places.size() != 1) return std::nullopt;
    places[mode_of(mode).places[0]].first.push_back(mode);
  }
  for (u32 mode : bad) {
    if (mode_of(mode).places.size() != 1) return std::nullopt;
    places[mode_of(mode).places[0]].second.push_back(mode);
  }
  const auto at = [&](u32 place) { return instance.path + '@' + type.places[place]; };
  Clause somewhere;  // at a place where there are good modes
  u32 mixed = kNoRow;
  for (const auto& [place, modes] : places) {
    if (modes.first.empty()) continue;
    somewhere.push_back(at(place));
    if (modes.second.empty()) continue;
    if (mixed != kNoRow) return std::nullopt;
    mixed = place;
  }
  std::vector<Clause> clauses;
  if (somewhere.size() < type.places.size()) clauses.push_back(somewhere);
  if (mixed == kNoRow) return clauses;
  const auto& [good_there, bad_there] = places[mixed];
  const bool is_one_bad = bad_there.size() == 1;
  if (!is_one_bad && good_there.size() != 1) return std::nullopt;
  const Mode& one = mode_of(is_one_bad ? bad_there[0] : good_there[0]);
  // The slots that tell it from the others.
  std::vector<std::size_t> slots;
  for (std::size_t k = 0; k < type.slots.size(); ++k) {
    if (row.followed[k] != 0 && one.values[k].is_known && !type.slots[k].is_param) slots.push_back(k);
  }
  for (u32 other : is_one_bad ? good_there : bad_there) {
    const bool differs = std::any_of(slots.begin(), slots.end(), [&](std::size_t k) { return mode_of(other).values[k].is_known && mode_of(other).values[k] != one.values[k]; });
    if (!differs) return std::nullopt;
  }
  Clause none{"!" + at(mixed)};
  for (std::size_t k : slots) {
    const std::string is_it = instance.path + '.' + type.slots[k].name + '=' + std::to_string(one.values[k].value);
    none.push_back("!" + is_it);
    if (is_one_bad) continue;
    Clause clause;
    for (const std::string& place : somewhere) {
      if (place != at(mixed)) clause.push_back(place);
    }
    clause.push_back(is_it);
    clauses.push_back(std::move(clause));
  }
  if (is_one_bad) clauses.push_back(std::move(none));
  return clauses;
}

std::optional<std::vector<std::string>> SumClauses::lemmas(const Side& side, std::size_t limit) const {
  std::vector<std::string> result;
  if (side.least <= 0) return result;
  if (side.clauses() > static_cast<double>(limit)) return std::nullopt;
  std::vector<std::vector<Clause>> atoms;
  for (std::size_t k = 0; k < side.good.size(); ++k) {
    std::optional<std::vector<Clause>> clauses = told(side.good[k], side.bad[k]);
    if (!clauses) return std::nullopt;
    atoms.push_back(std::move(*clauses));
  }
  bool is_small = true;
  each_subset(atoms.size(), atoms.size() - static_cast<std::size_t>(side.least) + 1, [&](const std::vector<std::size_t>& chosen) {
    std::vector<std::string> rows{"lemma"};
    for (std::size_t atom : chosen) {
      std::vector<std::string> longer;
      for (const std::string& row : rows) {
        for (const Clause& clause : atoms[atom]) {
          longer.push_back(row);
          for (const std::string& literal : clause) longer.back() += ' ' + literal;
        }
      }
      rows = std::move(longer);
      is_small = is_small && rows.size() <= limit;
      if (!is_small) return false;
    }
    result.insert(result.end(), rows.begin(), rows.end());
    is_small = result.size() <= limit;
    return is_small;
  });
  if (!is_small) return std::nullopt;
  return result;
}

void SumClauses::add(const Side& side, Encoding& encoding) const {
  if (side.least <= 0) return;
  each_subset(side.good.size(), side.good.size() - static_cast<std::size_t>(side.least) + 1, [&](const std::vector<std::size_t>& chosen) {
    std::vector<Lit> clause;
    for (std::size_t atom : chosen) {
      // One of the good, or not the only bad one.
      if (side.bad[atom].size() == 1) clause.push_back(-encoding.literal(side.bad[atom][0]));
      else for (u32 mode : side.good[atom]) clause.push_back(encoding.literal(mode));
    }
    encoding.add_clause(clause);
    return true;
  });
}

}  // namespace bip::verify
