// See split_sets.hpp.
#include "runtime/distributed/split_sets.hpp"

#include <algorithm>
#include <optional>
#include <tuple>

#include "bip/assert.hpp"
#include "runtime/core/fire/partial.hpp"

namespace bip::rt {

namespace {

bool shows_objects(const Tables& tables, const Distribution& distribution, u32 atom) {
  return std::any_of(distribution.cells[atom].begin(), distribution.cells[atom].end(), [&](VariableId cell) {
    return is_ffi(tables.atom_type(atom).variables[cell - tables.atoms[atom].first_cell].type);
  });
}

// Why the set cannot be split; none: it can.
std::optional<WholeSet> obstacle(const Tables& tables, const PartialState& partial, const Distribution& distribution,
                                 u32 set) {
  if (has_time(*tables.image)) return WholeSet::Time;
  const Span<u32> atoms = distribution.sets.atoms[set];
  const auto is_elsewhere = [&](u32 atom) { return distribution.home(atom) != distribution.home(atoms[0]); };
  if (std::none_of(atoms.begin(), atoms.end(), is_elsewhere)) return WholeSet::OneNode;
  const Span<InteractionId> all = distribution.sets.interactions[set];
  const auto is_evaluated_between = [&](InteractionId at) { return partial.groups_of_interaction[at].size != 0; };
  // A fault of a guard or an `up` is one of the step before, and no attempt may come for long.
  if (distribution.may_fault && std::any_of(all.begin(), all.end(), is_evaluated_between)) return WholeSet::Fault;
  const auto shows = [&](u32 atom) { return shows_objects(tables, distribution, atom); };
  if (std::any_of(atoms.begin(), atoms.end(), shows)) return WholeSet::Objects;
  return std::nullopt;
}

class SetSplitter {
 public:
  SetSplitter(const Tables& tables, const PriorityTables& rules, Distribution& distribution)
      : tables_(tables), distribution_(distribution), sets_(distribution.sets), partial_(link_partial(tables, rules)) {}

  void split() {
    distribution_.is_split.assign(sets_.count, 0);
    bool is_any = false;
    for (u32 set = 0; set < sets_.count; ++set) {
      if (!must_be_split(set)) continue;
      is_any = true;
      distribution_.is_split[set] = 1;
    }
    if (!is_any) return;
    find_needs();
    find_occasions();
    choose_coordinators();
    share_occasions();
    forget_sets_that_come_apart();
  }

 private:
  struct Occasion {
    u32 atom = 0;
    u32 place_row = kNone;            // row of set_at; kNone: of situations, or of an atom that is looked at
    u32 first = kNone, last = kNone;  // rows of situations
    bool is_looked_at = false;
  };

  [[nodiscard]] bool must_be_split(u32 set) const {
    return sets_.interactions[set].size > distribution_.placement.split_above &&
           !obstacle(tables_, partial_, distribution_, set).has_value();
  }
  [[nodiscard]] bool is_of_split_set(InteractionId interaction) const {
    return distribution_.is_split[sets_.of_interaction[interaction]] != 0;
  }

  // What takes part, and what is looked at.
  void find_needs() {
    const u32 group_count = static_cast<u32>(partial_.busy_in_group.size());
    const Csr atoms_of_group = partial_.groups_of_atom.transposed(group_count);
    std::vector<RowsByInteraction::Pair> needs;
    is_looked_at_.assign(tables_.image->atoms.size, 0);
    for (const InteractionId interaction : tables_.interactions.ids()) {
      if (!is_of_split_set(interaction)) continue;
      for (const u32 atom : partial_.atoms_of_interaction[interaction]) needs.push_back({interaction, atom});
      for (const u32 group : partial_.groups_of_interaction[interaction]) {
        for (const u32 atom : atoms_of_group[group]) {
          needs.push_back({interaction, atom});
          is_looked_at_[atom] = 1;
        }
      }
    }
    RowsByInteraction::sort_unique(needs);
    distribution_.needs = RowsByInteraction::build(tables_.interactions.size(), needs);
  }

  void find_occasions() {
    occasion_of_place_.assign(sets_.set_at.size(), kNone);
    occasion_of_atom_.assign(tables_.image->atoms.size, kNone);
    occasion_of_row_.assign(sets_.situations.size(), kNone);
    number_situations();
    std::vector<InteractionsBy::Pair> pairs;
    std::vector<u32> ports;
    for (const InteractionId interaction : tables_.interactions.ids()) {
      if (!is_of_split_set(interaction)) continue;
      for (const u32 atom : distribution_.needs[interaction]) {
        if (is_looked_at_[atom] != 0)
          pairs.push_back({occasion_of(occasion_of_atom_[atom], {atom, kNone, kNone, kNone, true}), interaction});
      }
      ports_of_interaction(tables_, tables_.interactions[interaction], ports);
      for (const u32 port : ports) {
        const u32 atom = tables_.port_atom[port];
        if (is_looked_at_[atom] != 0 || sets_.by_situation[atom] != 0) continue;
        const LinkedType& type = tables_.types[tables_.atoms[atom].type];
        for (u32 row = type.first_transition; row < type.first_transition + type.transition_count; ++row) {
          if (tables_.transitions[row].port != port - tables_.port_base(atom)) continue;
          const u32 place_row = sets_.row_of_place(atom, tables_.transitions[row].from);
          pairs.push_back(
              {occasion_of(occasion_of_place_[place_row], {atom, place_row, kNone, kNone, false}), interaction});
        }
      }
    }
    add_next_moves(pairs);
    InteractionsBy::sort_unique(pairs);
    interactions_ = InteractionsBy::build(occasions_.size(), pairs);
  }

  u32 occasion_of(u32& number, const Occasion& occasion) {
    if (number == kNone) {
      number = static_cast<u32>(occasions_.size());
      occasions_.push_back(occasion);
    }
    return number;
  }

  // Ports that a situation offers to one set are one occasion.
  void number_situations() {
    for (u32 row = 0; row < sets_.situations.size(); ++row) {
      const ConflictSets::Situation& at = sets_.situations[row];
      if (distribution_.is_split[at.set] == 0) continue;
      u32 same = row;
      while (same > 0 && is_same(sets_.situations[same - 1], at)) --same;
      while (same < row && sets_.situations[same].set != at.set) ++same;
      if (same == row) {
        (void)occasion_of(occasion_of_row_[row], {at.atom, kNone, row, row, false});
      } else {
        occasion_of_row_[row] = occasion_of_row_[same];
        occasions_[occasion_of_row_[row]].last = row;
      }
    }
  }
  static bool is_same(const ConflictSets::Situation& a, const ConflictSets::Situation& b) {
    return std::tuple(a.atom, a.place, a.history) == std::tuple(b.atom, b.place, b.history);
  }

  void add_next_moves(std::vector<InteractionsBy::Pair>& pairs) const {
    if (distribution_.placement.next_moves.empty()) return;
    std::vector<InteractionsBy::Pair> by_port;
    std::vector<u32> ports;
    for (const InteractionId interaction : tables_.interactions.ids()) {
      ports_of_interaction(tables_, tables_.interactions[interaction], ports);
      for (const u32 port : ports) by_port.push_back({port, interaction});
    }
    const InteractionsBy interactions_of_port = InteractionsBy::build(tables_.port_atom.size(), by_port);
    for (const NextMove& move : distribution_.placement.next_moves) {
      if (sets_.by_situation[move.atom] == 0) continue;
      const u32 row = sets_.situation_of(move.atom, move.place, move.history, move.port);
      if (row == kNone || occasion_of_row_[row] == kNone) continue;
      if (move.connector != kNone) {
        pairs.push_back({occasion_of_row_[row], tables_.interaction_of(move.connector)});
        continue;
      }
      for (const InteractionId interaction : interactions_of_port[tables_.instance(move.atom, move.port)])
        pairs.push_back({occasion_of_row_[row], interaction});
    }
  }

  void choose_coordinators() {
    IndexVector<InteractionId, u32> first(tables_.interactions.size(), kNone);
    for (u32 occasion = 0; occasion < occasions_.size(); ++occasion) {
      if (interactions_[occasion].size < 2) continue;
      for (const InteractionId interaction : interactions_[occasion])
        first[interaction] = std::min(first[interaction], distribution_.home(occasions_[occasion].atom));
    }
    for (const InteractionId interaction : tables_.interactions.ids()) {
      if (!is_of_split_set(interaction)) continue;
      u32& coordinator = distribution_.coordinator_of[interaction];
      // Without a contended atom no other interaction needs its atoms.
      coordinator =
          first[interaction] != kNone ? first[interaction] : distribution_.home(distribution_.needs[interaction][0]);
    }
  }

  void share_occasions() {
    std::vector<std::tuple<InteractionId, u32, u32>> locks;  // interaction, home, atom
    for (u32 number = 0; number < occasions_.size(); ++number) {
      const Occasion& occasion = occasions_[number];
      const Span<InteractionId> all = interactions_[number];
      if (all.size == 0) continue;
      const auto coordinator = [&](InteractionId interaction) { return distribution_.coordinator_of[interaction]; };
      const bool is_shared = std::any_of(
          all.begin(), all.end(), [&](InteractionId other) { return coordinator(other) != coordinator(all[0]); });
      const u32 home = distribution_.home(occasion.atom);
      offer(occasion, is_shared ? home : coordinator(all[0]));
      if (!is_shared) continue;
      for (const InteractionId interaction : all) locks.emplace_back(interaction, home, occasion.atom);
    }
    std::sort(locks.begin(), locks.end());
    locks.erase(std::unique(locks.begin(), locks.end()), locks.end());
    std::vector<RowsByInteraction::Pair> pairs;
    for (const auto& [interaction, home, atom] : locks) {
      BIP_ASSERT(home >= distribution_.coordinator_of[interaction], "a lock of interaction {} before its coordinator",
                 interaction);
      BIP_ASSERT(
          std::binary_search(distribution_.needs[interaction].begin(), distribution_.needs[interaction].end(), atom),
          "interaction {} locks atom {}, which it does not need", interaction, atom);
      pairs.push_back({interaction, atom});
    }
    distribution_.locks = RowsByInteraction::build(tables_.interactions.size(), pairs);
  }

  void offer(const Occasion& occasion, u32 node) {
    BIP_ASSERT(node < distribution_.placement.nodes.size(), "an occasion of atom {} at node {}", occasion.atom, node);
    if (occasion.is_looked_at) {
      std::fill(distribution_.offered_at.begin() + sets_.first_place[occasion.atom],
                distribution_.offered_at.begin() + sets_.first_place[occasion.atom + 1], node);
    } else if (occasion.place_row != kNone) {
      distribution_.offered_at[occasion.place_row] = node;
    } else {
      for (u32 row = occasion.first; row <= occasion.last; ++row) {
        if (occasion_of_row_[row] == occasion_of_row_[occasion.first]) distribution_.offered_in[row] = node;
      }
    }
  }

  void forget_sets_that_come_apart() {
    for (u32 set = 0; set < sets_.count; ++set) {
      if (distribution_.is_split[set] == 0) continue;
      const Span<InteractionId> all = sets_.interactions[set];
      const u32 coordinator = distribution_.coordinator_of[all[0]];
      if (std::any_of(all.begin(), all.end(),
                      [&](InteractionId other) { return distribution_.coordinator_of[other] != coordinator; }))
        continue;
      distribution_.is_split[set] = 0;
      distribution_.coordinator[set] = coordinator;
    }
  }

  const Tables& tables_;
  Distribution& distribution_;
  const ConflictSets& sets_;
  PartialState partial_;
  std::vector<std::uint8_t> is_looked_at_;  // by atom
  std::vector<Occasion> occasions_;
  std::vector<u32> occasion_of_place_, occasion_of_atom_, occasion_of_row_;
  InteractionsBy interactions_;  // by occasion
};

}  // namespace

void split_sets(const Tables& tables, const PriorityTables& rules, Distribution& distribution) {
  SetSplitter(tables, rules, distribution).split();
}

std::vector<std::pair<u32, WholeSet>> find_whole_sets(const Tables& tables, const PriorityTables& rules,
                                                      const Distribution& distribution, u32 split_above) {
  const ConflictSets& sets = distribution.sets;
  BIP_ASSERT(distribution.is_split.size() == sets.count, "{} of {} sets are split or not", distribution.is_split.size(),
             sets.count);
  const PartialState partial = link_partial(tables, rules);
  std::vector<std::pair<u32, WholeSet>> found;
  for (u32 set = 0; set < sets.count; ++set) {
    if (distribution.is_split[set] != 0 || sets.interactions[set].size <= split_above) continue;
    found.emplace_back(set, obstacle(tables, partial, distribution, set).value_or(WholeSet::NothingShared));
  }
  return found;
}

}  // namespace bip::rt
