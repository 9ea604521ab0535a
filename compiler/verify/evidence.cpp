// See evidence.hpp.
#include "compiler/verify/evidence.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "compiler/verify/sum_clauses.hpp"

namespace bip::verify {

namespace {
// More values of a slot at a place are told as a range, if they are one.
constexpr std::size_t kMaxListed = 64;

class Finder {
 public:
  Finder(const Net& plain, const Net& told, const Proof& proof, Clock::time_point end)
      : told_(told), proof_(proof), end_(end), clauses_(told, proof.reachable) {
    evidence_.net = build_net(plain, told.uses, UsesAs::Hidden);
  }

  std::optional<Evidence> run() {
    const Net& net = evidence_.net;
    if (net.too_large_atom != kNoRow) return std::nullopt;
    Spread reachable(net, Direction::Forward, nullptr);
    spread_from_initial(net, reachable, evidence_.proof);
    if (!match_modes()) return std::nullopt;
    TrapFinder checker(net, reachable);
    std::vector<std::pair<SumClauses::Side, SumClauses::Side>> open;
    std::vector<const TokenInvariant*> kept;
    for (const TokenInvariant& invariant : proof_.invariants) {
      if (std::optional<TokenInvariant> same = projected(invariant, checker)) {
        evidence_.proof.invariants.push_back(std::move(*same));
        kept.push_back(&invariant);
        continue;
      }
      auto sides = clauses_.sides(invariant);
      if (!sides) return std::nullopt;
      if (sides->second.clauses() < sides->first.clauses() && sides->second.least > 0) std::swap(sides->first, sides->second);
      open.push_back(std::move(*sides));
    }
    bool is_enough = false;
    for (const bool with_both : {false, true}) {
      if (is_enough) break;
      is_enough = suffices(kept, open, with_both);
      if (is_enough && !add_lemmas(open, with_both)) return std::nullopt;
    }
    if (!is_enough) return std::nullopt;
    for (u32 atom = 0; atom + 1 < told_.mode_base.size(); ++atom) add_values(atom);
    return std::move(evidence_);
  }

 private:
  // To each mode the one that it is without the hidden values.
  bool match_modes() {
    const Net& net = evidence_.net;
    same_.assign(told_.mode_count(), kNoRow);
    for (u32 atom = 0; atom + 1 < told_.mode_base.size(); ++atom) {
      const ModeClass& row = told_.class_at(atom);
      const ModeClass& other = net.class_at(atom);
      for (u32 mode = 0; mode < row.modes.size(); ++mode) {
        if (proof_.reachable[told_.mode_base[atom] + mode] == 0) continue;
        u32 found = kNoRow;
        if (row.uses == nullptr) found = mode;
        for (u32 k = 0; k < other.modes.size() && found == kNoRow; ++k) {
          bool fits = other.modes[k].places == row.modes[mode].places;
          for (std::size_t s = 0; s < row.followed.size() && fits; ++s) fits = !other.modes[k].values[s].is_known || other.modes[k].values[s] == row.modes[mode].values[s];
          if (fits) found = k;
        }
        if (found == kNoRow) return false;
        same_[told_.mode_base[atom] + mode] = net.mode_base[atom] + found;
      }
    }
    return true;
  }

  // The same invariant without the values, if it says nothing of them and holds without them.
  std::optional<TokenInvariant> projected(const TokenInvariant& invariant, TrapFinder& checker) const {
    std::map<u32, std::int64_t> weights;
    for (std::size_t k = 0; k < invariant.modes.size();) {
      const u32 atom = told_.atom_of_mode[invariant.modes[k]];
      for (u32 mode = told_.mode_base[atom]; mode < told_.mode_base[atom + 1]; ++mode) {
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
    const bool holds = invariant.kind == InvariantKind::Trap ? checker.holds_trap(result.modes) : checker.keeps_sum(result);
    return holds ? std::optional(std::move(result)) : std::nullopt;
  }

  bool suffices(const std::vector<const TokenInvariant*>& kept, const std::vector<std::pair<SumClauses::Side, SumClauses::Side>>& open, bool with_both) {
    Spread reachable(told_, Direction::Forward, nullptr);
    Proof again;
    spread_from_initial(told_, reachable, again);
    Encoding encoding(told_, reachable);
    for (const TokenInvariant* invariant : kept) {
      if (!encoding.add(*invariant)) return false;
    }
    double count = 0;
    for (const auto& [small, large] : open) {
      count += small.clauses() + (with_both ? large.clauses() : 0);
      if (count > static_cast<double>(Evidence::kMaxClauses)) return false;
      clauses_.add(small, encoding);
      if (with_both) clauses_.add(large, encoding);
    }
    return encoding.solve(seconds_until(end_)) == Answer::Unsatisfiable;
  }

  bool add_lemmas(const std::vector<std::pair<SumClauses::Side, SumClauses::Side>>& open, bool with_both) {
    for (const auto& [small, large] : open) {
      for (const SumClauses::Side* side : {&small, &large}) {
        if (side == &large && !with_both) continue;
        const auto lemmas = clauses_.lemmas(*side, Evidence::kMaxClauses);
        if (!lemmas) return false;
        evidence_.rows.insert(evidence_.rows.end(), lemmas->begin(), lemmas->end());
        if (evidence_.rows.size() > Evidence::kMaxClauses) return false;
      }
    }
    return true;
  }

  // What the modes know and the evidence's do not: where the atom never is, and which values a slot has at a place.
  void add_values(u32 atom) {
    const Net& net = evidence_.net;
    const ModeClass& row = told_.class_at(atom);
    const ModeClass& other = net.class_at(atom);
    const Atom& instance = told_.system->atoms[AtomId(std::size_t{atom})];
    const AtomType& type = told_.system->atom_types[row.type];
    std::set<u32> left, places;  // modes of the evidence, places of all
    for (u32 mode = net.mode_base[atom]; mode < net.mode_base[atom + 1]; ++mode) {
      if (evidence_.proof.reachable[mode] == 0) continue;
      left.insert(mode);
      const std::vector<u32>& at = other.modes[mode - net.mode_base[atom]].places;
      if (at.size() == 1) places.insert(at[0]);
    }
    std::map<u32, std::vector<const Mode*>> by_place;
    for (u32 mode = 0; mode < row.modes.size(); ++mode) {
      const u32 number = told_.mode_base[atom] + mode;
      if (same_[number] == kNoRow) continue;
      left.erase(same_[number]);
      if (row.modes[mode].places.size() == 1) by_place[row.modes[mode].places[0]].push_back(&row.modes[mode]);
    }
    for (u32 place : places) {
      if (!by_place.contains(place)) evidence_.rows.push_back("lemma !" + instance.path + '@' + type.places[place]);
    }
    for (std::size_t slot = 0; slot < row.followed.size(); ++slot) {
      const bool is_hidden = other.followed[slot] == 0;
      if (row.followed[slot] == 0 || type.slots[slot].is_param || (!is_hidden && left.empty())) continue;
      const std::string name = instance.path + '.' + type.slots[slot].name;
      std::set<std::int32_t> all;
      bool wants_range = false;
      std::vector<std::string> lemmas;
      for (const auto& [place, modes] : by_place) {
        std::set<std::int32_t> values;
        bool is_open = false;
        for (const Mode* mode : modes) {
          if (mode->values[slot].is_known) values.insert(mode->values[slot].value);
          else is_open = true;
        }
        if (is_open) continue;
        all.insert(values.begin(), values.end());
        wants_range = wants_range || values.size() > kMaxListed;
        lemmas.push_back("lemma !" + instance.path + '@' + type.places[place]);
        for (std::int32_t value : values) lemmas.back() += ' ' + name + '=' + std::to_string(value);
      }
      if (wants_range && is_range(type, slot, all)) lemmas = {"range " + name + ' ' + std::to_string(*all.begin()) + ' ' + std::to_string(*all.rbegin())};
      evidence_.rows.insert(evidence_.rows.end(), lemmas.begin(), lemmas.end());
    }
  }
  // All ints between two, and the first value is one of them.
  [[nodiscard]] bool is_range(const AtomType& type, std::size_t slot, const std::set<std::int32_t>& values) const {
    if (type.slots[slot].type != Type::Int) return false;
    if (std::int64_t{*values.rbegin()} - *values.begin() + 1 != static_cast<std::int64_t>(values.size())) return false;
    std::vector<AbstractValue> first(type.slots.size());
    first[slot] = known(0);
    execute(told_.system->code, type.initial_action, first);
    return first[slot].is_known && values.contains(first[slot].value);
  }

  const Net& told_;
  const Proof& proof_;
  Clock::time_point end_;
  SumClauses clauses_;
  std::vector<u32> same_;  // by mode of told_: of the evidence's net
  Evidence evidence_;
};

}  // namespace

std::optional<Evidence> find_evidence(const Net& plain, const Net& told, const Proof& proof, Clock::time_point end) {
  return Finder(plain, told, proof, end).run();
}

}  // namespace bip::verify
