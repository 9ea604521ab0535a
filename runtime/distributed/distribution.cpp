// See distribution.hpp.
#include "runtime/distributed/distribution.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "bip/assert.hpp"
#include "runtime/core/fire/partial.hpp"
#include "runtime/core/programs/batch_plan.hpp"
#include "runtime/core/time/clocks.hpp"
#include "runtime/distributed/split_sets.hpp"

namespace bip::rt {

namespace {

// Disjoint sets, by halving paths.
class UnionFind {
 public:
  explicit UnionFind(u32 size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }
  u32 find(u32 x) {
    while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
    return x;
  }
  void join(u32 x, u32 y) { parent_[std::max(find(x), find(y))] = std::min(find(x), find(y)); }

 private:
  std::vector<u32> parent_;
};

bool has_object(const Tables& tables, u32 atom, VariableId cell) {
  return is_ffi(tables.atom_type(atom).variables[cell - tables.atoms[atom].first_cell].type);
}

// Does a transition of the port leave the place? Of Petri types: any.
bool can_fire_at(const Tables& tables, u32 port, u32 place) {
  const u32 atom = tables.port_atom[port];
  const LinkedType& type = tables.types[tables.atoms[atom].type];
  const auto first = tables.transitions.begin() + type.first_transition;
  return std::any_of(first, first + type.transition_count, [&](const LinkedTransition& transition) {
    return transition.port == port - tables.port_base(atom) && (type.mark_words != 0 || transition.from == place);
  });
}

// An atom, by its first cell.
using FirstCell = CsrOf<VariableId, u32>::Pair;

u32 atom_of_cell(const std::vector<FirstCell>& by_cell, VariableId cell) {
  const auto after = std::upper_bound(by_cell.begin(), by_cell.end(), cell,
                                      [](VariableId row, const FirstCell& first) { return row < first.from; });
  BIP_ASSERT(after != by_cell.begin(), "cell {} is no atom's", cell);
  return std::prev(after)->to;
}

// What is evaluated between steps: an `up`, a guard of a connector, a rule.
bool may_fault_between_steps(const Image& image) {
  return std::any_of(image.priorities.begin(), image.priorities.end(),
                     [](const Priority& rule) { return rule.guard != kNone; }) ||
         std::any_of(image.connector_types.begin(), image.connector_types.end(), [](const ConnectorType& type) {
           return std::any_of(type.clauses.begin(), type.clauses.end(),
                              [](const Clause& clause) { return clause.may_fault || clause.guard_may_fault; });
         });
}

}  // namespace

VariablesBy shown_cells(const Tables& tables) {
  const Image& image = *tables.image;
  const u32 atom_count = image.atoms.size;
  std::vector<VariablesBy::Pair> shown;
  std::vector<FirstCell> by_cell;
  for (u32 atom = 0; atom < atom_count; ++atom) {
    const VariableId first = tables.atoms[atom].first_cell;
    if (tables.atom_type(atom).variables.size != 0) by_cell.push_back({first, atom});
    for (const Port& port : tables.atom_type(atom).ports) {
      for (const u32 variable : port.variables) shown.push_back({atom, first + variable});
    }
  }
  std::sort(by_cell.begin(), by_cell.end(), [](const FirstCell& a, const FirstCell& b) { return a.from < b.from; });
  const auto read = [&](u32 bind) {
    const VariableId cell = image.binds[bind].variable();
    if (cell.value < tables.atom_cells) shown.push_back({atom_of_cell(by_cell, cell), cell});
  };
  for (u32 connector = 0; connector < image.connectors.size; ++connector) {
    const Connector& row = image.connectors[connector];
    for (u32 i = 0; i < row.bind_count; ++i) read(row.binds + i);
  }
  for (const Priority& rule : image.priorities) {
    for (u32 i = 0; i < rule.bind_count; ++i) read(rule.binds + i);
  }
  VariablesBy::sort_unique(shown);
  return VariablesBy::build(atom_count, shown);
}

// The same, of tables that were linked before.
static ConflictSets conflict_sets(const Tables& tables, const PartialState& partial,
                                  const std::vector<NextMove>& next_moves) {
  BIP_ASSERT(std::is_sorted(next_moves.begin(), next_moves.end(),
                            [](const NextMove& a, const NextMove& b) {
                              return std::tuple(a.atom, a.place, a.history, a.mode) <
                                     std::tuple(b.atom, b.place, b.history, b.mode);
                            }),
             "{} next moves are not in order", next_moves.size());
  const u32 interaction_count = static_cast<u32>(tables.interactions.size());
  const u32 atom_count = tables.image->atoms.size;
  const InteractionsBy movers = partial.atoms_of_interaction.transposed(atom_count);
  const u32 group_count = static_cast<u32>(partial.busy_in_group.size());
  const Csr atoms_of_group = partial.groups_of_atom.transposed(group_count);
  const InteractionsBy dependents = partial.groups_of_interaction.transposed(group_count);

  // Interactions, then atoms: those in a group, with all that moves them.
  UnionFind sets(interaction_count + atom_count);
  std::vector<std::uint8_t> is_looked_at(atom_count, 0);
  for (u32 group = 0; group < group_count; ++group) {
    if (dependents[group].size == 0) continue;
    const u32 first = dependents[group][0].value;
    for (const InteractionId interaction : dependents[group]) sets.join(first, interaction.value);
    for (const u32 atom : atoms_of_group[group]) {
      is_looked_at[atom] = 1;
      sets.join(first, interaction_count + atom);
    }
  }
  for (u32 atom = 0; atom < atom_count; ++atom) {
    for (const InteractionId interaction : movers[atom]) {
      if (is_looked_at[atom] != 0) sets.join(interaction_count + atom, interaction.value);
    }
  }

  ConflictSets result;
  for (u32 atom = 0; atom < atom_count; ++atom) {
    result.first_place.push_back(static_cast<u32>(result.set_at.size()));
    const bool is_automaton = tables.types[tables.atoms[atom].type].mark_words == 0;
    result.set_at.resize(result.set_at.size() + (is_automaton ? tables.atom_type(atom).places.size : 1), kNone);
  }
  result.first_place.push_back(static_cast<u32>(result.set_at.size()));

  // An atom that is looked at is moved by one set, whatever is known of it.
  result.by_situation.assign(atom_count, 0);
  result.is_told_apart.assign(tables.port_atom.size(), 0);
  for (const NextMove& move : next_moves) {
    if (is_looked_at[move.atom] != 0) continue;
    result.by_situation[move.atom] = 1;
    if (move.connector != kNone) result.is_told_apart[tables.instance(move.atom, move.port)] = 1;
  }
  // By now set_at holds one of the interactions at the place, at the end its set.
  std::vector<u32> ports;
  std::vector<Csr::Pair> atoms;
  std::vector<InteractionsBy::Pair> by_port;
  for (const InteractionId interaction : tables.interactions.ids()) {
    ports_of_interaction(tables, tables.interactions[interaction], ports);
    for (const u32 port : ports) {
      const u32 atom = tables.port_atom[port];
      if (!next_moves.empty()) by_port.push_back({port, interaction});
      if (result.by_situation[atom] != 0) continue;
      const LinkedType& type = tables.types[tables.atoms[atom].type];
      for (u32 row = type.first_transition; row < type.first_transition + type.transition_count; ++row) {
        if (tables.transitions[row].port != port - tables.port_base(atom)) continue;
        u32& there =
            result.set_at[result.first_place[atom] + (type.mark_words == 0 ? tables.transitions[row].from : 0)];
        if (there == kNone) there = interaction.value;
        else sets.join(there, interaction.value);
      }
    }
  }
  // So do the rows of situations.
  const InteractionsBy interactions_of_port = InteractionsBy::build(tables.port_atom.size(), by_port);
  const NextMove* last = nullptr;
  u32 before = kNone;  // an interaction of the same mode
  for (const NextMove& move : next_moves) {
    if (result.by_situation[move.atom] == 0) continue;
    if (last == nullptr || std::tuple(last->atom, last->place, last->history, last->mode) !=
                               std::tuple(move.atom, move.place, move.history, move.mode))
      before = kNone;
    last = &move;
    const Span<InteractionId> all = interactions_of_port[tables.instance(move.atom, move.port)];
    const bool is_alone = move.connector != kNone;
    if (!is_alone && all.size == 0) continue;
    const u32 interaction = (is_alone ? tables.interaction_of(move.connector) : all[0]).value;
    for (u32 k = 0; !is_alone && k < all.size; ++k) sets.join(interaction, all[k].value);
    if (before != kNone) sets.join(interaction, before);
    before = interaction;
    result.situations.push_back({move.atom, move.place, move.history, move.port, interaction});
  }
  const auto key = [](const ConflictSets::Situation& at) { return std::tuple(at.atom, at.place, at.history, at.port); };
  std::stable_sort(result.situations.begin(), result.situations.end(),
                   [&](const auto& a, const auto& b) { return key(a) < key(b); });
  for (std::size_t row = 1; row < result.situations.size(); ++row) {
    if (key(result.situations[row - 1]) == key(result.situations[row]))
      sets.join(result.situations[row - 1].set, result.situations[row].set);
  }
  result.situations.erase(std::unique(result.situations.begin(), result.situations.end(),
                                      [&](const auto& a, const auto& b) { return key(a) == key(b); }),
                          result.situations.end());
  std::vector<u32> number(interaction_count + atom_count, kNone);
  for (const InteractionId interaction : tables.interactions.ids()) {
    u32& set = number[sets.find(interaction.value)];
    if (set == kNone) set = result.count++;
    result.of_interaction.push(set);
    for (const u32 atom : partial.atoms_of_interaction[interaction]) atoms.push_back({set, atom});
  }
  for (u32& set : result.set_at) set = set == kNone ? kNone : result.of_interaction[InteractionId(set)];
  for (ConflictSets::Situation& at : result.situations) at.set = result.of_interaction[InteractionId(at.set)];
  for (u32 atom = 0; atom < atom_count; ++atom) {
    if (is_looked_at[atom] == 0) continue;
    const u32 set = number[sets.find(interaction_count + atom)];
    BIP_ASSERT(set != kNone, "no interaction depends on atom {}, which is looked at", atom);
    std::fill(result.set_at.begin() + result.first_place[atom], result.set_at.begin() + result.first_place[atom + 1],
              set);
    atoms.push_back({set, atom});
  }
  Csr::sort_unique(atoms);
  result.atoms = Csr::build(result.count, atoms);
  std::vector<InteractionsBy::Pair> members;
  for (const InteractionId interaction : tables.interactions.ids())
    members.push_back({result.of_interaction[interaction], interaction});
  result.interactions = InteractionsBy::build(result.count, members);
  return result;
}

ConflictSets conflict_sets(const Tables& tables, const PriorityTables& rules, const std::vector<NextMove>& next_moves) {
  return conflict_sets(tables, link_partial(tables, rules), next_moves);
}

u32 ConflictSets::situation_of(u32 atom, u32 place, u32 history, u32 port) const {
  const auto key = [](const Situation& at) { return std::tuple(at.atom, at.place, at.history, at.port); };
  const std::tuple wanted(atom, place, history, port);
  const auto at = std::lower_bound(situations.begin(), situations.end(), wanted,
                                   [&](const Situation& row, const auto& value) { return key(row) < value; });
  return at != situations.end() && key(*at) == wanted ? static_cast<u32>(at - situations.begin()) : kNone;
}

Placement place_atoms(const Tables& tables, const PriorityTables& rules, u32 nodes) {
  BIP_ASSERT(nodes != 0 && nodes <= kMostNodes, "{} nodes", nodes);
  const u32 atom_count = tables.image->atoms.size;
  const PartialState partial = link_partial(tables, rules);
  const InteractionsBy movers = partial.atoms_of_interaction.transposed(atom_count);
  Placement placement;
  for (u32 node = 1; node <= nodes; ++node) placement.nodes.push_back(std::to_string(node));
  for (const std::uint8_t part : parts_of_atoms(partial.atoms_of_interaction, movers, atom_count, nodes))
    placement.home.push_back(part);
  // Objects stay where they are: who shows one is at home where the first such atom of its set is.
  const std::vector<u32> first_of = atoms_together(tables, rules);
  for (u32 atom = 0; atom < atom_count; ++atom) placement.home[atom] = placement.home[first_of[atom]];
  return placement;
}

std::vector<u32> atoms_together(const Tables& tables, const PriorityTables& rules) {
  const u32 atom_count = tables.image->atoms.size;
  const PartialState partial = link_partial(tables, rules);
  const VariablesBy cells = shown_cells(tables);
  const auto shows_object = [&](u32 atom) {
    return std::any_of(cells[atom].begin(), cells[atom].end(),
                       [&](VariableId cell) { return has_object(tables, atom, cell); });
  };
  const ConflictSets sets = conflict_sets(tables, partial, {});
  UnionFind together(atom_count);
  for (u32 set = 0; set < sets.count; ++set) {
    u32 first = kNone;
    for (const u32 atom : sets.atoms[set]) {
      if (!shows_object(atom)) continue;
      if (first == kNone) first = atom;
      together.join(first, atom);
    }
  }
  std::vector<u32> result;
  for (u32 atom = 0; atom < atom_count; ++atom) result.push_back(together.find(atom));
  return result;
}

JoinReason why_joined(const Tables& tables, const PriorityTables& rules, const ConflictSets& sets, u32 set) {
  const PartialState partial = link_partial(tables, rules);
  const u32 group_count = static_cast<u32>(partial.busy_in_group.size());
  const InteractionsBy movers = partial.atoms_of_interaction.transposed(tables.image->atoms.size);
  const Csr atoms_of_group = partial.groups_of_atom.transposed(group_count);
  const InteractionsBy dependents = partial.groups_of_interaction.transposed(group_count);
  JoinReason best;
  std::vector<InteractionId> joined;
  const auto consider = [&](JoinReason reason) {
    std::sort(joined.begin(), joined.end());
    joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
    if (joined.size() <= best.joined.size()) return;
    reason.joined = joined;
    best = std::move(reason);
  };
  for (u32 group = 0; group < group_count; ++group) {
    if (dependents[group].size == 0 || sets.of_interaction[dependents[group][0]] != set) continue;
    joined.assign(dependents[group].begin(), dependents[group].end());
    for (const u32 atom : atoms_of_group[group]) joined.insert(joined.end(), movers[atom].begin(), movers[atom].end());
    JoinReason reason;
    for (const InteractionId interaction : tables.interactions.ids()) {
      if (partial.own_group[interaction] == group) reason = {JoinReason::Kind::Connector, interaction.value, kNone, {}};
    }
    for (u32 rule = 0; rule < rules.count && reason.row == kNone; ++rule) {
      if (partial.group_of_component[rules.component[rule]] == group)
        reason = {JoinReason::Kind::Rule, rule, kNone, {}};
    }
    consider(std::move(reason));
  }
  if (best.row != kNone) return best;
  std::vector<u32> ports;
  for (const u32 atom : sets.atoms[set]) {
    const LinkedType& type = tables.types[tables.atoms[atom].type];
    const u32 places = type.mark_words == 0 ? tables.atom_type(atom).places.size : 1;
    for (u32 place = 0; place < places; ++place) {
      joined.clear();
      for (const InteractionId interaction : movers[atom]) {
        ports_of_interaction(tables, tables.interactions[interaction], ports);
        const bool leaves = std::any_of(ports.begin(), ports.end(), [&](u32 port) {
          return tables.port_atom[port] == atom && can_fire_at(tables, port, place);
        });
        if (leaves && sets.of_interaction[interaction] == set) joined.push_back(interaction);
      }
      consider({JoinReason::Kind::Place, atom, type.mark_words == 0 ? place : kNone, {}});
    }
  }
  return best;
}

namespace {

// Of the first port for events that a C++ class brings.
SourceLine place_of_event_source(const Image& image) {
  for (const Atom& atom : image.atoms) {
    const AtomType& type = image.atom_types[atom.type];
    if (type.time == nullptr) continue;
    for (const EventPort& event : type.time->events) {
      if (event.source != kNone) return type.ports[event.port].loc;
    }
  }
  return {};
}

}  // namespace

bool has_event_sources(const Image& image) { return image.event_classes.size != 0; }

TimeOnNodes time_on_nodes(const Image& image) {
  constexpr const char* kOne = "run it on one: `--engine=sequential`";
  if (!has_time(image)) return {};
  if (has_event_sources(image))
    return {"a model with events from C++", "no node has the instants at which events come", kOne,
            place_of_event_source(image)};
  for (const ConnectorType& type : image.connector_types) {
    if (type.resume_sync)
      return {"a model with `resume sync`", "components on several nodes would have to agree on an instant", kOne,
              type.loc};
  }
  if (const OpenEager open = find_open_eager(image); open.eager != nullptr)
    return {"a model with `eager` beside a bound with `>`", "no node knows whether time must stop before an open bound",
            std::string("bound it with `>=`, or ") + kOne, open.eager->loc, open.open_bound->loc};
  return {};
}

namespace {

// An interaction of both atoms, or else one of the second. Requires: there is one.
InteractionId meeting_of(const Tables& tables, Span<InteractionId> interactions, u32 atom, u32 other) {
  InteractionId found;
  std::vector<u32> ports;
  for (const InteractionId interaction : interactions) {
    ports_of_interaction(tables, tables.interactions[interaction], ports);
    const auto takes = [&](u32 one) {
      return std::any_of(ports.begin(), ports.end(), [&](u32 port) { return tables.port_atom[port] == one; });
    };
    if (!takes(other)) continue;
    if (takes(atom)) return interaction;
    if (!found.is_valid()) found = interaction;
  }
  BIP_ASSERT(found.is_valid(), "atom {} is in no interaction of its set", other);
  return found;
}

}  // namespace

Distribution distribute(const Tables& tables, const PriorityTables& rules, Placement placement) {
  Distribution result;
  result.placement = std::move(placement);
  result.sets = conflict_sets(tables, rules, result.placement.next_moves);
  result.cells = shown_cells(tables);
  result.may_fault = may_fault_between_steps(*tables.image);
  BIP_ASSERT(result.placement.home.size() == tables.image->atoms.size, "{} atoms have a home",
             result.placement.home.size());
  const u32 nodes = static_cast<u32>(result.placement.nodes.size());
  std::vector<u32> ports;
  for (u32 set = 0; set < result.sets.count; ++set) {
    std::vector<u32> votes(nodes, 0);
    for (const InteractionId interaction : result.sets.interactions[set]) {
      ports_of_interaction(tables, tables.interactions[interaction], ports);
      for (const u32 port : ports) ++votes[result.home(tables.port_atom[port])];
    }
    u32 chosen = static_cast<u32>(std::max_element(votes.begin(), votes.end()) - votes.begin());
    CrossingObject object;  // the first of the set
    for (const u32 atom : result.sets.atoms[set]) {
      for (const VariableId cell : result.cells[atom]) {
        if (!has_object(tables, atom, cell)) continue;
        if (object.atom == kNone) {
          object = {atom, cell - tables.atoms[atom].first_cell, kNone, {}};
          chosen = result.home(atom);
        } else if (result.home(atom) != chosen && object.other == kNone) {
          object.other = atom;
          object.meeting = meeting_of(tables, result.sets.interactions[set], object.atom, atom);
          result.crossing.push_back(object);
        }
      }
    }
    result.coordinator.push_back(chosen);
  }
  for (const u32 set : result.sets.of_interaction) result.coordinator_of.push(result.coordinator[set]);
  const auto node_of = [&](u32 set) { return set == kNone ? kNone : result.coordinator[set]; };
  for (const u32 set : result.sets.set_at) result.offered_at.push_back(node_of(set));
  for (const ConflictSets::Situation& at : result.sets.situations) result.offered_in.push_back(node_of(at.set));
  // What is locked is planned by no node.
  if (has_time(*tables.image)) result.placement.split_above = kSplitNone;
  split_sets(tables, rules, result);
  BIP_ASSERT(
      std::all_of(result.coordinator_of.begin(), result.coordinator_of.end(), [&](u32 at) { return at < nodes; }),
      "an interaction has no coordinator among {} nodes", nodes);
  return result;
}

}  // namespace bip::rt
