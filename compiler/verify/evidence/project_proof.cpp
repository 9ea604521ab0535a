// See project_proof.hpp.
#include "compiler/verify/evidence/project_proof.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "compiler/system/system.hpp"
#include "compiler/verify/invariants/token_invariant_checker.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {
// More values of a variable at a place are written as a range, if they are one.
constexpr std::size_t kMaxListed = 64;
// Of one row, so that sums of a few are none of other numbers.
constexpr std::int64_t kMaxWeight = 1'000'000;

// Modes at one place, and what they count for.
using Weighted = std::vector<std::pair<const Mode*, std::int64_t>>;

class ProofProjection {
 public:
  ProofProjection(const Net& plain, const Net& distinguishing, const Proof& proof)
      : distinguishing_(distinguishing), proof_(proof) {
    projected_.net = build_net(plain, distinguishing.uses, UsesAs::Hidden);
  }

  std::optional<ProjectedProof> run() {
    const Net& net = projected_.net;
    if (net.too_large_atom != kNoRow) return std::nullopt;
    ModeReachability reachable(net, Direction::Forward, nullptr);
    spread_from_initial(net, reachable, projected_.proof);
    if (!match_modes()) return std::nullopt;
    TokenInvariantChecker checker(net, reachable);
    for (const TokenInvariant& invariant : proof_.invariants) {
      if (std::optional<TokenInvariant> same = projected(invariant, checker))
        projected_.proof.invariants.push_back(std::move(*same));
      else if (!add_row(invariant) || words_ > ProjectedProof::kMaxWords) return std::nullopt;
    }
    for (u32 atom = 0; atom + 1 < distinguishing_.mode_base.size(); ++atom) add_values(atom);
    return std::move(projected_);
  }

 private:
  // To each mode the one that it is without the hidden values.
  bool match_modes() {
    const Net& net = projected_.net;
    same_.assign(distinguishing_.mode_count(), kNoRow);
    for (u32 atom = 0; atom + 1 < distinguishing_.mode_base.size(); ++atom) {
      const ModeClass& row = distinguishing_.class_at(atom);
      const ModeClass& other = net.class_at(atom);
      for (u32 mode = 0; mode < row.modes.size(); ++mode) {
        if (proof_.reachable[distinguishing_.mode_base[atom] + mode] == 0) continue;
        u32 found = kNoRow;
        if (row.uses == nullptr) found = mode;
        for (u32 k = 0; k < other.modes.size() && found == kNoRow; ++k) {
          bool fits = other.modes[k].places == row.modes[mode].places;
          for (std::size_t s = 0; s < row.followed.size() && fits; ++s)
            fits = !other.modes[k].values[s].is_known || other.modes[k].values[s] == row.modes[mode].values[s];
          if (fits) found = k;
        }
        if (found == kNoRow) return false;
        same_[distinguishing_.mode_base[atom] + mode] = net.mode_base[atom] + found;
      }
    }
    return true;
  }

  // The same invariant without the values, if it says nothing of them and holds without them.
  std::optional<TokenInvariant> projected(const TokenInvariant& invariant, TokenInvariantChecker& checker) const {
    std::map<u32, std::int64_t> weights;
    for (std::size_t k = 0; k < invariant.modes.size();) {
      const u32 atom = distinguishing_.atom_of_mode[invariant.modes[k]];
      for (u32 mode = distinguishing_.mode_base[atom]; mode < distinguishing_.mode_base[atom + 1]; ++mode) {
        const bool is_in = k < invariant.modes.size() && invariant.modes[k] == mode;
        const std::int64_t weight = is_in ? weight_of(invariant, k) : 0;
        if (is_in) ++k;
        if (same_[mode] == kNoRow) continue;
        if (weights.try_emplace(same_[mode], weight).first->second != weight) return std::nullopt;
      }
    }
    TokenInvariant result{invariant.kind, {}, {}, invariant.total};
    for (const auto& [mode, weight] : weights) {
      if (weight == 0) continue;
      result.modes.push_back(mode);
      if (invariant.kind == InvariantKind::Sum) result.weights.push_back(weight);
    }
    return checker.holds(result) ? std::optional(std::move(result)) : std::nullopt;
  }

  // The invariant as one row about places and values: a lemma for a trap, an equation for a sum.
  bool add_row(const TokenInvariant& invariant) {
    const bool is_trap = invariant.kind == InvariantKind::Trap;
    std::int64_t total = invariant.total;
    std::string row;
    for (std::size_t k = 0; k < invariant.modes.size();) {
      const u32 atom = distinguishing_.atom_of_mode[invariant.modes[k]];
      std::map<u32, Weighted> by_place;
      std::map<std::int64_t, std::size_t> counts;
      for (u32 mode = distinguishing_.mode_base[atom]; mode < distinguishing_.mode_base[atom + 1]; ++mode) {
        const bool is_in = k < invariant.modes.size() && invariant.modes[k] == mode;
        const std::int64_t weight = !is_in ? 0 : is_trap ? 1 : weight_of(invariant, k);
        if (is_in) ++k;
        if (proof_.reachable[mode] == 0) continue;
        const Mode& of = distinguishing_.class_at(atom).modes[mode - distinguishing_.mode_base[atom]];
        if (of.places.size() != 1 || std::abs(weight) > kMaxWeight) return false;
        by_place[of.places[0]].emplace_back(&of, weight);
      }
      for (const auto& [place, modes] : by_place) ++counts[most_common(modes)];
      // What the atom adds wherever it is is no news.
      std::int64_t always = 0;
      for (const auto& [weight, count] : counts) always = !is_trap && count > counts[always] ? weight : always;
      total -= always;
      for (auto& [place, modes] : by_place) {
        for (auto& [mode, weight] : modes) weight -= always;
        if (!add_row(atom, place, modes, is_trap, row)) return false;
      }
    }
    projected_.rows.push_back((is_trap ? "lemma" : "equation " + std::to_string(total)) + row);
    return true;
  }
  [[nodiscard]] static std::int64_t most_common(const Weighted& modes) {
    std::map<std::int64_t, std::size_t> counts;
    for (const auto& [mode, weight] : modes) ++counts[weight];
    return std::max_element(counts.begin(), counts.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
  }
  // What most modes of a place weigh is said of the place, and of the others what they weigh more: values must tell
  // them apart.
  bool add_row(u32 atom, u32 place, const Weighted& modes, bool is_trap, std::string& row) {
    const std::int64_t base = most_common(modes);
    const auto others =
        std::count_if(modes.begin(), modes.end(), [&](const auto& mode) { return mode.second != base; });
    const Atom& instance = distinguishing_.system->atoms[AtomId(std::size_t{atom})];
    const AtomType& type = distinguishing_.system->atom_types[distinguishing_.class_at(atom).type];
    const std::string at = instance.path + '@' + type.places[place];
    const auto add = [&](const std::string& what, std::int64_t weight) {
      ++words_;
      row += ' ' + what + (is_trap ? "" : '*' + std::to_string(weight));
    };
    if (base != 0 && (!is_trap || others == 0)) add(at, base);
    for (const auto& [mode, weight] : modes) {
      if (weight == base) continue;
      std::vector<std::string> values;
      for (std::size_t k = 0; k < type.variables.size(); ++k) {
        if (is_listed(atom, *mode, k))
          values.push_back(instance.path + '.' + type.variables[k].name + '=' + std::to_string(mode->values[k].value));
      }
      for (const auto& [other, its] : modes) {
        if (its != weight && !differ(atom, *mode, *other)) return false;
      }
      if (is_trap && base != 0) {
        // All but this one are in the trap.
        if (others != 1) return false;
        for (const std::string& value : values) add(at + "&!" + value, 1);
        continue;
      }
      std::string all = at;
      for (const std::string& value : values) all += '&' + value;
      add(all, weight - base);
    }
    return true;
  }
  [[nodiscard]] bool is_listed(u32 atom, const Mode& mode, std::size_t variable) const {
    const ModeClass& row = distinguishing_.class_at(atom);
    return row.followed[variable] != 0 && mode.values[variable].is_known &&
           !distinguishing_.system->atom_types[row.type].variables[variable].is_param;
  }
  [[nodiscard]] bool differ(u32 atom, const Mode& a, const Mode& b) const {
    for (std::size_t k = 0; k < a.values.size(); ++k) {
      if (is_listed(atom, a, k) && is_listed(atom, b, k) && a.values[k] != b.values[k]) return true;
    }
    return false;
  }

  // What the modes know and the evidence's do not: where the atom never is, and which values a variable has at a place.
  void add_values(u32 atom) {
    const Net& net = projected_.net;
    const ModeClass& row = distinguishing_.class_at(atom);
    const ModeClass& other = net.class_at(atom);
    const Atom& instance = distinguishing_.system->atoms[AtomId(std::size_t{atom})];
    const AtomType& type = distinguishing_.system->atom_types[row.type];
    std::set<u32> left, places;  // modes of the evidence, places of all
    for (u32 mode = net.mode_base[atom]; mode < net.mode_base[atom + 1]; ++mode) {
      if (projected_.proof.reachable[mode] == 0) continue;
      left.insert(mode);
      const std::vector<u32>& at = other.modes[mode - net.mode_base[atom]].places;
      if (at.size() == 1) places.insert(at[0]);
    }
    std::map<u32, std::vector<const Mode*>> by_place;
    for (u32 mode = 0; mode < row.modes.size(); ++mode) {
      const u32 number = distinguishing_.mode_base[atom] + mode;
      if (same_[number] == kNoRow) continue;
      left.erase(same_[number]);
      if (row.modes[mode].places.size() == 1) by_place[row.modes[mode].places[0]].push_back(&row.modes[mode]);
    }
    for (u32 place : places) {
      if (!by_place.contains(place)) projected_.rows.push_back("lemma !" + instance.path + '@' + type.places[place]);
    }
    for (std::size_t variable = 0; variable < row.followed.size(); ++variable) {
      const bool is_hidden = other.followed[variable] == 0;
      if (row.followed[variable] == 0 || type.variables[variable].is_param || (!is_hidden && left.empty())) continue;
      const std::string name = instance.path + '.' + type.variables[variable].name;
      std::set<std::int32_t> all;
      bool wants_range = false;
      std::vector<std::string> lemmas;
      for (const auto& [place, modes] : by_place) {
        std::set<std::int32_t> values;
        bool is_open = false;
        for (const Mode* mode : modes) {
          if (mode->values[variable].is_known) values.insert(mode->values[variable].value);
          else is_open = true;
        }
        if (is_open) continue;
        all.insert(values.begin(), values.end());
        wants_range = wants_range || values.size() > kMaxListed;
        lemmas.push_back("lemma !" + instance.path + '@' + type.places[place]);
        for (std::int32_t value : values) lemmas.back() += ' ' + name + '=' + std::to_string(value);
      }
      if (wants_range && is_range(type, variable, all))
        lemmas = {"lemma " + name + '=' + std::to_string(*all.begin()) + ".." + std::to_string(*all.rbegin())};
      projected_.rows.insert(projected_.rows.end(), lemmas.begin(), lemmas.end());
    }
  }
  // All ints between two, and the first value is one of them.
  [[nodiscard]] bool is_range(const AtomType& type, std::size_t variable, const std::set<std::int32_t>& values) const {
    if (type.variables[variable].type != Type::Int) return false;
    if (std::int64_t{*values.rbegin()} - *values.begin() + 1 != static_cast<std::int64_t>(values.size())) return false;
    std::vector<AbstractValue> first(type.variables.size());
    first[variable] = known(0);
    execute(distinguishing_.system->code, type.initial_action, first);
    return first[variable].is_known && values.contains(first[variable].value);
  }

  const Net& distinguishing_;
  const Proof& proof_;
  std::vector<u32> same_;  // by mode of distinguishing_: of the evidence's net
  std::size_t words_ = 0;
  ProjectedProof projected_;
};

}  // namespace

std::optional<ProjectedProof> project_proof(const Net& plain, const Net& distinguishing, const Proof& proof) {
  BIP_ASSERT(proof.end == ProofEnd::Free, "only a proof is projected");
  BIP_ASSERT(proof.reachable.size() == distinguishing.mode_count(), "a proof about {} modes for a net of {}",
             proof.reachable.size(), distinguishing.mode_count());
  return ProofProjection(plain, distinguishing, proof).run();
}

}  // namespace bip::verify
