// What the core derives from an image once, before the first step: flat numbers for port instances, transitions by
// place, the availability network (one counter a group of a connector's `define` tree) and what watches what.
//
// Cost: linear in the image, plus one plan (an expanded tree) for each connector that is not a flat rendezvous.
// Constant afterwards; every Core of the same image could share it.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "bip/assert.hpp"
#include "bip/ids.hpp"
#include "bip/image.hpp"
#include "runtime/core/link/interactions.hpp"

namespace bip::rt {

/// A table from rows to rows: rows [first[i], first[i + 1]) of `items` belong to i. Without items there is no `first`
/// either: many tables are empty. From and To are ids, or plain row numbers.
template <class From, class To>
struct CsrOf {
  std::vector<u32> first;
  std::vector<To> items;
  [[nodiscard]] Span<To> operator[](From row) const {
    if (items.empty()) return {};
    const std::size_t i = number_of(row);
    BIP_ASSERT(i + 1 < first.size(), "row {} of {}", i, first.size() - 1);
    return {items.data() + first[i], first[i + 1] - first[i]};
  }
  struct Pair {
    From from;
    To to;
  };
  /// Keeps the order of pairs with equal `from`.
  static CsrOf build(std::size_t rows, const std::vector<Pair>& pairs);
  /// Returns the rows of each item, ascending; all items are below `item_count`.
  [[nodiscard]] CsrOf<To, From> transposed(std::size_t item_count) const;
  /// Sorts the pairs and keeps one of those that are equal.
  static void sort_unique(std::vector<Pair>& pairs);
  /// Keeps one of the pairs that are equal. Requires that the items of each row ascend. O(rows + pairs).
  static void unique_in_order(std::size_t rows, std::vector<Pair>& pairs);
};
using Csr = CsrOf<u32, u32>;
using InteractionsBy = CsrOf<u32, InteractionId>;  // of an atom, a port, a rule, ...: interactions
using RowsByInteraction = CsrOf<InteractionId, u32>;
using VariablesBy = CsrOf<u32, VariableId>;

template <class From, class To>
CsrOf<From, To> CsrOf<From, To>::build(std::size_t rows, const std::vector<Pair>& pairs) {
  CsrOf csr;
  if (pairs.empty()) return csr;
  // While items are placed, first[i + 1] is where the next item of row i goes; after the last item that is its end.
  csr.first.assign(rows + 2, 0);
  for (const Pair& pair : pairs) ++csr.first[number_of(pair.from) + 2];
  for (std::size_t i = 2; i <= rows; ++i) csr.first[i + 1] += csr.first[i];
  BIP_ASSERT(csr.first[rows + 1] == pairs.size(), "{} pairs in {} rows", pairs.size(), rows);
  csr.items.resize(pairs.size());
  for (const Pair& pair : pairs) csr.items[csr.first[number_of(pair.from) + 1]++] = pair.to;
  csr.first.pop_back();
  return csr;
}

template <class From, class To>
CsrOf<To, From> CsrOf<From, To>::transposed(std::size_t item_count) const {
  std::vector<typename CsrOf<To, From>::Pair> pairs;
  pairs.reserve(items.size());
  for (u32 row = 0; row + 1 < first.size(); ++row) {
    for (u32 at = first[row]; at < first[row + 1]; ++at) pairs.push_back({items[at], From(row)});
  }
  return CsrOf<To, From>::build(item_count, pairs);
}

template <class From, class To>
void CsrOf<From, To>::sort_unique(std::vector<Pair>& pairs) {
  const auto key = [](const Pair& p) { return u64{number_of(p.from)} << 32 | number_of(p.to); };
  std::sort(pairs.begin(), pairs.end(), [&](const Pair& a, const Pair& b) { return key(a) < key(b); });
  pairs.erase(std::unique(pairs.begin(), pairs.end(), [&](const Pair& a, const Pair& b) { return key(a) == key(b); }),
              pairs.end());
}

template <class From, class To>
void CsrOf<From, To>::unique_in_order(std::size_t rows, std::vector<Pair>& pairs) {
  std::vector<u32> last(rows, kNone);
  std::size_t kept = 0;
  for (const Pair& pair : pairs) {
    u32& before = last[number_of(pair.from)];
    BIP_ASSERT(before == kNone || before <= number_of(pair.to), "item {} comes after {}", number_of(pair.to), before);
    if (before == number_of(pair.to)) continue;
    before = number_of(pair.to);
    pairs[kept++] = pair;
  }
  pairs.resize(kept);
}

// ---- atoms -------------------------------------------------------------------------------------------------------
constexpr u32 kWatchedByData = 1;   // by many, whose code has the same answers for the same data
constexpr u32 kWatchedByCalls = 2;  // by few, by a rule's guard, by code that may call C++, or they are C++ objects
struct AtomInfo {
  u32 port_base = 0;      // number of its port 0 among all port instances
  VariableId first_cell;  // its variables stand from here on
  u32 type = 0;
  u32 watched = 0;  // 0: no guard or rule reads its data; kWatchedByData, kWatchedByCalls
};
/// What there is to do after a transition's action, until the atom's ports are up to date.
enum class Settling : std::uint8_t {
  Nothing,  // the atom's state and its ports stay as they are, without time too
  Flips,    // of a simple type: its deltas
  Rows,     // of a local type: its deltas, then what guards decide
  All       // AtomSteps::settle_atom: the atom has time, internal transitions, invariants, priorities or tokens
};
struct LinkedTransition {
  Code guard, action;                // fn null: none
  u32 port;                          // of the type; kNone: internal
  u32 from, to;                      // the place, if the type is an automaton
  u32 delta_first, delta_count;      // rows of Tables::deltas, of a local type: what changes for sure
  u32 guarded_first, guarded_count;  // rows of Tables::guarded_ports, of a local type: what guards decide
  const Transition* source;
  Settling settling = Settling::All;
  bool is_idle = false;  // the atom's state and its ports stay as they are
};
/// Firing a transition makes `transition` (or none) the enabled one of `port`.
struct PortDelta {
  u32 port, transition;
};
/// The same if the guard holds, else none.
struct GuardedPort {
  Code guard;
  u32 port, transition;
};
struct LinkedType {
  u32 first_transition = 0, transition_count = 0;  // rows of Tables::transitions
  u32 first_place = 0;                             // rows of place_transitions and place_internals (automata)
  u32 mark_words = 0;                              // 64-bit words of a marking; 0: automaton, the marking is one place
  bool fixed = false;   // automaton without guards and internal transitions: its marking says which ports are enabled
  bool simple = false;  // fixed, and each port labels one transition: a port is enabled iff the atom is at its place
  bool one_each =
      false;  // automaton, at most one transition for each place and port: whether it is enabled is its guard's
  bool is_local = false;  // one_each, and nothing but places and guards says what its ports offer
  bool has_internal = false;
  bool has_priorities = false;
  bool has_invariants = false;
  bool is_timed = false;
  Code initial;
};

// ---- connectors --------------------------------------------------------------------------------------------------
enum class NodeKind : std::uint8_t { Group, Leaf, Link, Choice };
/// A node of a plan, preorder. A Link is a parameter bound to a connector; its one child is that connector's root
/// group. A Choice is a parameter bound to a merged port; of its children, Leaves and Links, exactly one is chosen.
struct PlanNode {
  NodeKind kind = NodeKind::Group;
  bool trigger = false;       // among its siblings
  bool has_trigger = false;   // Group: among its children
  bool maximal_only = false;  // Link; Choice: always true, for it is as rigid
  u32 parent = kNone;         // row in the plan
  u32 end = 0;                // one past its subtree
  u32 children = 0;           // Group, Link, Choice: number of
  u32 ref = 0;                // Leaf: port instance
  u32 leaf = 0;               // number of leaves before it
  u32 use = 0;                // the plan's use of a connector that it belongs to; Link: the use it leads to
};
/// A connector within a plan; parents before children.
struct PlanUse {
  u32 connector = 0;
  u32 root = 0;             // its root group, row in the plan
  u32 first_param = 0;      // rows of plan_params: node of each parameter, row in the plan
  u32 link = kNone;         // node
  u32 clause = kNone;       // for all of its parameters
  bool has_choice = false;  // a parameter is bound to a merged port: where its variables are depends on the alternative
  u32 first_leaf = 0, end_leaf = 0;  // of its part of the plan
};
/// A member of a group of inner rules that a plan watches: a tree of its own, behind the plan's.
struct PlanWitness {
  u32 group = 0;
  u32 connector = 0;
  u32 use = 0, root = 0;  // rows in the plan
};
/// How to list the ports of a plan that chooses by triggers alone, in the order of firing: which ports and groups are
/// available decides, and a group has a node in the availability network that knows.
struct PlanChoice {
  enum class Kind : std::uint8_t {
    Port,           // takes part
    PortIfEnabled,  // is below a trigger
    Group           // what follows, up to `end`, takes part only if it is available
  };
  Kind kind = Kind::Port;
  u32 ref = 0;  // port instance; Group: node of the availability network
  u32 end = 0;  // Group: row of plan_choices
};
/// Code that a rigid plan runs as it fires, after its first `port_end` ports.
struct PlanTransfer {
  u32 code = kNone;  // row of the image's codes; kNone: none
  u32 connector = 0;
  VariableId first_cell;  // of the connector's own data
  u32 zeroed = 0;         // so many of them are zero when it begins
  u32 binds = 0;          // row of the bound variables
  u32 port_end = 0;
};
struct Plan {
  u32 connector = 0;
  u32 first_node = 0, node_count = 0;
  u32 first_use = 0, use_count = 0;
  u32 leaves = 0, words = 0;  // 64-bit words of a configuration
  // Rows of plan_ports and plan_transfers: of a rigid plan without witnesses, its ports in the order of firing, and
  // what runs between them.
  u32 first_port = 0, port_count = 0;
  u32 first_transfer = 0, end_transfer = 0;
  // Rows of plan_choices: of a plan that is not rigid, without guards, merged ports and code to fire.
  u32 first_choice = 0, end_choice = 0;
  bool guarded = false;  // a clause in its tree has a guard, or an `up` that may fault
  bool rigid = true;     // no triggers and no choices: one configuration, all ports
  // Rigid, and its guards are found bottom up, each connector's once: without inner rules, in a tree in which all
  // parameters show only maximal interactions, or none does.
  bool is_listed_at_once = false;
  bool has_choice = false;
  bool is_tree = true;                 // no connector has two uses
  std::vector<PlanWitness> witnesses;  // by depth of the group's compound, deepest last
  bool needs_ups = true;               // to fire: a `down` may read what they compute, or C++ sees that they run
  bool has_ranges =
      false;  // what its clauses do is known over ranges of values, and it has configurations to choose from
};

/// Compounds in whose priorities connectors take part that export a port. Such a connector is no interaction of its
/// own: its candidates are what it offers to the connectors above, so that rules decide while those are searched. All
/// rules of such a compound are decided there (search/interaction_search.cpp).
struct InnerRules {
  struct Group {
    u32 compound = 0;
    u32 depth = 0;             // of the compound
    std::vector<u32> members;  // connectors that its rules may name, in image order
    std::vector<u32> rules;
  };
  std::vector<Group> groups;
  std::vector<u32> group_of_connector;  // kNone: none. Empty: there are no groups
  std::vector<u32> group_of_rule;       // the same
  [[nodiscard]] u32 of_connector(u32 connector) const {
    return group_of_connector.empty() ? kNone : group_of_connector[connector];
  }
  [[nodiscard]] u32 of_rule(u32 rule) const { return group_of_rule.empty() ? kNone : group_of_rule[rule]; }
};

struct Tables {
  const Image* image = nullptr;

  std::vector<LinkedType> types;
  std::vector<LinkedTransition> transitions;
  std::vector<PortDelta> deltas;
  std::vector<GuardedPort> guarded_ports;
  Csr place_transitions;        // by first_place + place: rows of transitions with a port
  Csr place_internals;          // the same, internal ones
  std::vector<AtomInfo> atoms;  // and one more, whose port_base is the number of port instances
  std::vector<u32> port_atom;   // by port instance
  std::vector<u64> idle_ports;  // a bit by port instance: to fire it changes nothing, ever. Empty: there are none
  std::vector<u32> mark_base;   // by atom (Petri types): first word. Empty: there are none
  u32 mark_words = 0;
  u32 atom_cells = 0;  // so many variables, which come first, belong to atoms

  Interactions interactions;
  std::vector<u32> flat_ports;
  std::vector<InteractionId> interaction_of_connector;  // none if it exports a port. Empty: none does, and interactions
                                                        // are rows of connectors
  u32 connector_interactions = 0;                       // interactions below are connectors, the rest internal ports

  // Availability network. Nodes [0, interactions.size()) are the interactions, the rest inner groups. A node is
  // available iff its value >= 0.
  std::vector<std::int32_t>
      inner_start;  // of inner groups: the value with every port disabled; of interactions: start_of
  std::vector<std::int32_t> interaction_start;  // by interaction, the same. Empty: what its connector says
  Csr node_out;                                 // by node: nodes that count it
  Csr port_out;                                 // by port instance: nodes that count it
  InteractionsBy port_watch;                    // by port instance: interactions to search again when it flips
  InteractionsBy atom_watch;                    // by atom: interactions that read its data
  Csr atom_rules;                               // by atom: priority rules that read its data
  bool any_port_watch = false;
  bool any_searched = false;

  std::vector<Plan> plans;
  std::vector<PlanNode> plan_nodes;
  std::vector<PlanUse> plan_uses;
  std::vector<u32> plan_params;
  std::vector<u32> plan_ports;
  std::vector<PlanTransfer> plan_transfers;
  std::vector<PlanChoice> plan_choices;
  Csr clause_order;  // by connector type: its clauses, sorted by their parameters
  InnerRules inner_rules;

  [[nodiscard]] const AtomType& atom_type(u32 atom) const { return image->atom_types[atoms[atom].type]; }
  [[nodiscard]] u32 port_base(u32 atom) const { return atoms[atom].port_base; }
  [[nodiscard]] const ConnectorType& connector_type(u32 connector) const {
    return image->connector_types[image->connectors[connector].type];
  }
  /// The first of the connector's bound rows beyond its parameters' variables: from there on they are data of atoms
  /// that its code reads by their paths.
  [[nodiscard]] u32 first_read(u32 connector) const {
    u32 first = 0;
    for (const ConnectorParam& param : connector_type(connector).params)
      first = std::max(first, param.first_bind + image->port_types[param.type].vars.size);
    return first;
  }
  [[nodiscard]] PortRef port_ref(u32 connector, u32 param) const {
    return image->port_refs[image->connectors[connector].ports + param];
  }
  /// The ports of an interaction in which always the same ones take part, in the order of firing: of a flat one, and of
  /// a planned one that is rigid. Empty: they have to be found.
  [[nodiscard]] Span<u32> fixed_ports(const InteractionInfo& info) const {
    if (info.kind == InteractionKind::Flat) return {flat_ports.data() + info.first, info.count};
    if (info.kind != InteractionKind::Planned || plans[info.plan()].port_count == 0) return {};
    return {plan_ports.data() + plans[info.plan()].first_port, plans[info.plan()].port_count};
  }
  /// Has it one candidate at most, in which all its parameters take part?
  [[nodiscard]] bool has_one_candidate(const InteractionInfo& info) const {
    if (!info.searched || info.kind == InteractionKind::Flat) return true;
    return info.kind == InteractionKind::Planned && plans[info.plan()].rigid && plans[info.plan()].witnesses.empty();
  }
  [[nodiscard]] u32 first_mark(u32 atom) const { return mark_base.empty() ? 0 : mark_base[atom]; }
  /// No interaction if it exports a port.
  [[nodiscard]] InteractionId interaction_of(u32 connector) const {
    return interaction_of_connector.empty() ? InteractionId(connector) : interaction_of_connector[connector];
  }
  /// Is it an interaction of a connector? Else it is an internal port.
  [[nodiscard]] bool is_of_connector(InteractionId interaction) const {
    return interaction.value < connector_interactions;
  }
  [[nodiscard]] IdRange<InteractionId> interactions_of_connectors() const {
    return IdRange<InteractionId>(connector_interactions);
  }
  /// Those of internal ports, which come after them.
  [[nodiscard]] IdRange<InteractionId> interactions_of_ports() const {
    return IdRange<InteractionId>(connector_interactions, interactions.size());
  }
  /// Of an interaction of a connector.
  [[nodiscard]] u32 connector_of(InteractionId interaction) const {
    BIP_ASSERT(is_of_connector(interaction), "interaction {} is an internal port", interaction);
    return interaction_of_connector.empty() ? interaction.value : interactions[interaction].row;
  }
  /// The node of the availability network that is the interaction, and the other way round.
  [[nodiscard]] static constexpr u32 node_of(InteractionId interaction) { return interaction.value; }
  [[nodiscard]] static constexpr InteractionId interaction_at(u32 node) { return InteractionId(node); }
  [[nodiscard]] bool is_interaction(u32 node) const { return node < interactions.size(); }
  [[nodiscard]] std::size_t node_count() const { return interactions.size() + inner_start.size(); }
  /// An interaction's value with every port disabled.
  [[nodiscard]] std::int32_t start_of(InteractionId interaction) const;
  [[nodiscard]] u32 instance(u32 atom, u32 port) const { return port_base(atom) + port; }
  /// The clause of a type for exactly these sorted parameters, or kNone. O(log clauses * params).
  [[nodiscard]] u32 clause_of(u32 connector_type_row, Span<u32> params) const;
  [[nodiscard]] Code code(u32 row) const { return row == kNone ? Code{} : image->codes[row]; }
};

/// What connectors and rules bind, as their code wants it: rows in `all`. The image's own ones, if those are not folded
/// and are never changed.
struct Binds {
  const u32* rows = nullptr;
  std::vector<u32> own;  // choices move rows of it
  void make(const Image& image);
};

enum class MaximalProgress : std::uint8_t { On, Off };

[[nodiscard]] Tables link(const Image& image, MaximalProgress progress);

// The parts of link, in this order.
void link_atoms(Tables& tables);
void link_inner_rules(Tables& tables);
void link_interactions(Tables& tables, MaximalProgress progress);
/// The ports of rigid plans, and their code.
void link_plan_transfers(Tables& tables);
void link_network(Tables& tables);
/// What counts what in the availability network: ports and nodes, and the nodes that count them.
struct NetworkEdges {
  std::vector<Csr::Pair> from_ports, from_nodes;
};
/// Lets groups go into the nodes that count them, where that says the same. After link_plan_choices.
void contract_network(Tables& tables, NetworkEdges& edges);
/// Connector k's groups that are no interactions are nodes from first_group[k] on, in the order of its `define`.
void link_plan_choices(Tables& tables, const std::vector<u32>& first_group);
void link_watches(Tables& tables);

}  // namespace bip::rt
