// Linking priorities: which interaction can hide which, and the graph of rules that chain. See priorities.hpp.
//
// Rule r chains into s if an interaction that `define` allows (it need not be enabled) matches r's high side and s's
// low side. With explicit patterns that is: the largest interaction within s's parameters has all of r's.
#include "runtime/core/link/priorities.hpp"

#include <algorithm>
#include <numeric>

#include "bip/assert.hpp"
#include "runtime/core/graph_algorithms.hpp"

namespace bip::rt {

namespace {

using Flags = std::vector<std::uint8_t>;

bool is_subset(const std::vector<u32>& params, Span<u32> of) {
  return std::includes(of.begin(), of.end(), params.begin(), params.end());
}
bool is_superset(const std::vector<u32>& params, Span<u32> of) {
  return std::includes(params.begin(), params.end(), of.begin(), of.end());
}

// The largest interaction of a connector type within the allowed parameters; empty if there is none.
std::vector<u32> largest_within(const ConnectorType& type, const Flags& allowed) {
  Flags available(type.define.size, 0), chosen(type.define.size, 0);
  for (u32 i = type.define.size; i-- > 0;) {
    const DefineNode& node = type.define[i];
    if (node.is_leaf) {
      available[i] = allowed[node.param];
      continue;
    }
    bool any_trigger = false, ready_trigger = false, all = node.children.size != 0;
    for (u32 child : node.children) {
      any_trigger |= type.define[child].trigger;
      ready_trigger |= type.define[child].trigger && available[child] != 0;
      all &= available[child] != 0;
    }
    available[i] = (any_trigger ? ready_trigger : all) ? 1 : 0;
  }
  chosen[0] = available[0];
  std::vector<u32> params;
  for (u32 i = 0; i < type.define.size; ++i) {
    const DefineNode& node = type.define[i];
    if (chosen[i] == 0) continue;
    if (node.is_leaf) params.push_back(node.param);
    for (u32 child : node.children) chosen[child] = available[child];
  }
  std::sort(params.begin(), params.end());
  return params;
}

// Interactions of one connector: within `within`, containing `containing`, not within `not_within`, not containing
// `not_containing`; null: no such condition.
struct Conditions {
  const Span<u32>* within = nullptr;
  const Span<u32>* containing = nullptr;
  const Span<u32>* not_within = nullptr;
  const Span<u32>* not_containing = nullptr;
};
bool exists(const ConnectorType& type, const Conditions& conditions) {
  Flags allowed(type.params.size, conditions.within == nullptr ? 1 : 0);
  if (conditions.within != nullptr) {
    for (u32 param : *conditions.within) allowed[param] = 1;
  }
  const auto fits = [&] {
    const std::vector<u32> params = largest_within(type, allowed);
    if (params.empty()) return false;
    if (conditions.containing != nullptr && !is_superset(params, *conditions.containing)) return false;
    return conditions.not_within == nullptr || !is_subset(params, *conditions.not_within);
  };
  if (conditions.not_containing == nullptr) return fits();
  BIP_ASSERT(std::is_sorted(conditions.not_containing->begin(), conditions.not_containing->end()),
             "parameters of a rule are not in order");
  for (u32 param : *conditions.not_containing) {
    const std::uint8_t before = allowed[param];
    allowed[param] = 0;
    if (fits()) return true;
    allowed[param] = before;
  }
  return false;
}

// Is there an interaction of the connector that matches `from`'s high side and `to`'s low side? False if the connector
// exports a port that no connector binds: then it takes no part in rules.
bool meet_at(const Tables& tables, const Priority& from, const Priority& to, u32 connector) {
  if (!tables.interaction_of(connector).is_valid() && tables.inner_rules.of_connector(connector) == kNone) return false;
  Conditions conditions;
  const auto in_scope = [&](const Priority& rule) { return tables.image->connectors[connector].parent == rule.parent; };
  if (from.high.any_connector) {
    if (!in_scope(from)) return false;
    if (from.low.connector == connector) {
      if (from.low.any_interaction) return false;
      conditions.not_within = &from.low.params;
    }
  } else {
    if (from.high.connector != connector) return false;
    if (!from.high.any_interaction) conditions.containing = &from.high.params;
  }
  if (to.low.any_connector) {
    if (!in_scope(to)) return false;
    if (to.high.connector == connector) {
      if (to.high.any_interaction) return false;
      conditions.not_containing = &to.high.params;
    }
  } else {
    if (to.low.connector != connector) return false;
    if (!to.low.any_interaction) conditions.within = &to.low.params;
  }
  return exists(tables.connector_type(connector), conditions);
}

// Interactions that a side of a rule may match.
std::vector<InteractionId> interactions_of(const Tables& tables, const Priority& rule, const Pattern& pattern,
                                           const Pattern& other) {
  std::vector<InteractionId> interactions;
  if (!pattern.any_connector) {
    const InteractionId interaction = tables.interaction_of(pattern.connector);
    if (interaction.is_valid()) interactions.push_back(interaction);
    return interactions;
  }
  for (const InteractionId interaction : tables.interactions_of_connectors()) {
    const u32 connector = tables.connector_of(interaction);
    if (tables.image->connectors[connector].parent != rule.parent) continue;
    if (!other.any_connector && other.any_interaction && other.connector == connector) continue;
    interactions.push_back(interaction);
  }
  return interactions;
}

u32 find(std::vector<u32>& parents, u32 x) {
  while (parents[x] != x) x = parents[x] = parents[parents[x]];
  return x;
}

// Rules that no topological order reaches are on or behind a cycle.
void mark_cyclic(PriorityTables& rules) {
  std::vector<u32> missing, order;
  for (u32 rule = 0; rule < rules.count; ++rule) missing.push_back(rules.previous[rule].size);
  const bool is_acyclic = topological_order(missing, order, [&](u32 rule, const auto& see) {
    for (u32 next : rules.next[rule]) see(next);
  });
  if (is_acyclic) return;
  for (u32 rule = 0; rule < rules.count; ++rule) {
    if (missing[rule] != 0) rules.cyclic[rules.component[rule]] = 1;
  }
}

// What comes and goes more than once in a step is followed more than once, so it may move no more than so many others.
constexpr std::size_t kMostFollowed = 32;

// Do the rules and interactions that may change with the interaction, through chains, number kMostFollowed at most?
bool moves_few(const PriorityTables& rules, InteractionId interaction) {
  std::vector<u32> reached;
  std::size_t moved = 0;
  const auto reach = [&](u32 rule) {
    if (std::find(reached.begin(), reached.end(), rule) != reached.end()) return;
    reached.push_back(rule);
    moved += 1 + rules.interactions_of_low[rule].size;
  };
  for (const u32 edge : rules.high_of_interaction[interaction]) {
    reach(rules.high_edges[edge].rule);
    if (moved > kMostFollowed) return false;
  }
  for (std::size_t at = 0; at < reached.size(); ++at) {
    for (const u32 before : rules.previous[reached[at]]) {
      reach(before);
      if (moved > kMostFollowed) return false;
    }
  }
  return true;
}

}  // namespace

bool matches_low(const Tables& tables, const Priority& rule, u32 connector, const std::vector<u32>& params) {
  if (rule.low.any_connector) {
    return tables.image->connectors[connector].parent == rule.parent &&
           (rule.high.any_connector || !matches_high(tables, rule, connector, params));
  }
  return rule.low.connector == connector && (rule.low.any_interaction || is_subset(params, rule.low.params));
}

bool matches_high(const Tables& tables, const Priority& rule, u32 connector, const std::vector<u32>& params) {
  if (rule.high.any_connector) {
    return tables.image->connectors[connector].parent == rule.parent &&
           (rule.low.any_connector || !matches_low(tables, rule, connector, params));
  }
  return rule.high.connector == connector && (rule.high.any_interaction || is_superset(params, rule.high.params));
}

PriorityTables link_priorities(const Tables& tables) {
  const Image& image = *tables.image;
  PriorityTables rules;
  rules.count = image.priorities.size;
  if (rules.count == 0) return rules;
  const std::size_t interaction_count = tables.interactions.size();
  rules.is_involved.assign(interaction_count, 0);
  for (const InteractionId interaction : tables.interactions.ids())
    rules.has_one_candidate.push(tables.has_one_candidate(tables.interactions[interaction]) ? 1 : 0);
  std::vector<RowsByInteraction::Pair> low;
  std::vector<InteractionsBy::Pair> low_back;
  std::vector<Csr::Pair> chain, chain_back;
  // Rules by the connector of their low side, to find successors without looking at every pair.
  std::vector<Csr::Pair> by_low;
  std::vector<u32> wildcard_low;
  for (u32 row = 0; row < rules.count; ++row) {
    const Priority& rule = image.priorities[row];
    if (rule.low.any_connector) wildcard_low.push_back(row);
    else by_low.push_back({rule.low.connector, row});
    // The search of interactions decides about those: here only their guards and chains count.
    if (tables.inner_rules.of_rule(row) != kNone) continue;
    // Where an interaction has several candidates, each is asked whether it matches when they are known.
    const auto may_match = [&](InteractionId interaction, const auto& matches) {
      if (!tables.has_one_candidate(tables.interactions[interaction])) return true;
      const u32 connector = tables.connector_of(interaction);
      std::vector<u32> params(tables.connector_type(connector).params.size);
      std::iota(params.begin(), params.end(), 0u);
      return matches(tables, rule, connector, params);
    };
    for (const InteractionId interaction : interactions_of(tables, rule, rule.low, rule.high)) {
      if (!may_match(interaction, matches_low)) continue;
      low.push_back({interaction, row});
      low_back.push_back({row, interaction});
      rules.is_involved[interaction] |= PriorityTables::kLow;
    }
    for (const InteractionId interaction : interactions_of(tables, rule, rule.high, rule.low)) {
      if (!may_match(interaction, matches_high)) continue;
      rules.high_edges.push_back({interaction, row});
      rules.is_involved[interaction] |= PriorityTables::kHigh;
    }
  }
  std::stable_sort(rules.high_edges.begin(), rules.high_edges.end(),
                   [](const HighEdge& a, const HighEdge& b) { return a.interaction < b.interaction; });
  std::vector<RowsByInteraction::Pair> edges_of_interaction;
  for (u32 i = 0; i < rules.high_edges.size(); ++i)
    edges_of_interaction.push_back({rules.high_edges[i].interaction, i});
  rules.high_of_interaction = RowsByInteraction::build(interaction_count, edges_of_interaction);
  rules.low_of_interaction = RowsByInteraction::build(interaction_count, low);
  rules.interactions_of_low = InteractionsBy::build(rules.count, low_back);

  const Csr starting = Csr::build(image.connectors.size, by_low);
  std::vector<u32> parents(rules.count);
  std::iota(parents.begin(), parents.end(), 0u);
  const auto add_chain = [&](u32 from, u32 to) {
    chain.push_back({from, to});
    chain_back.push_back({to, from});
    parents[find(parents, from)] = find(parents, to);
  };
  for (u32 from = 0; from < rules.count; ++from) {
    const Priority& rule = image.priorities[from];
    if (!rule.high.any_connector) {
      const u32 connector = rule.high.connector;
      for (u32 to : starting[connector]) {
        if (meet_at(tables, rule, image.priorities[to], connector)) add_chain(from, to);
      }
      for (u32 to : wildcard_low) {
        if (meet_at(tables, rule, image.priorities[to], connector)) add_chain(from, to);
      }
      continue;
    }
    for (u32 to = 0; to < rules.count; ++to) {
      const Priority& next = image.priorities[to];
      bool met = false;
      if (!next.low.any_connector) {
        met = meet_at(tables, rule, next, next.low.connector);
      } else if (next.parent == rule.parent) {
        for (const InteractionId interaction : tables.interactions_of_connectors())
          met = met || meet_at(tables, rule, next, tables.connector_of(interaction));
        if (const u32 group = tables.inner_rules.of_rule(from); group != kNone) {
          for (u32 member : tables.inner_rules.groups[group].members) met = met || meet_at(tables, rule, next, member);
        }
      }
      if (met) add_chain(from, to);
    }
  }
  rules.next = Csr::build(rules.count, chain);
  rules.previous = Csr::build(rules.count, chain_back);
  rules.component.resize(rules.count);
  std::vector<u32> number(rules.count, kNone);
  std::vector<Csr::Pair> members;
  u32 components = 0;
  for (u32 rule = 0; rule < rules.count; ++rule) {
    u32& known = number[find(parents, rule)];
    if (known == kNone) known = components++;
    rules.component[rule] = known;
    members.push_back({known, rule});
  }
  BIP_ASSERT(members.size() == rules.count, "{} rules in components, of {}", members.size(), rules.count);
  rules.members = Csr::build(components, members);
  rules.cyclic.assign(components, 0);
  BIP_ASSERT(std::is_sorted(rules.high_edges.begin(), rules.high_edges.end(),
                            [](const HighEdge& a, const HighEdge& b) { return a.interaction < b.interaction; }),
             "high sides are not in the order of interactions");
  mark_cyclic(rules);
  for (const InteractionId interaction : tables.interactions.ids()) {
    const bool is_followed = rules.is_involved[interaction] != 0 && !tables.interactions[interaction].searched &&
                             moves_few(rules, interaction);
    rules.is_followed.push(is_followed ? 1 : 0);
  }
  return rules;
}

}  // namespace bip::rt
