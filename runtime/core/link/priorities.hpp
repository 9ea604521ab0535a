// Priorities as tables: which interactions a rule can hide, which can make it hide, which rules chain into which.
//
// A candidate is hidden iff a rule with a true guard matches it as low, and a chain of rules with true guards (of
// length one or more) ends in a rule whose high side an enabled candidate matches. Chains go through interactions that
// need not be enabled, so they are a graph of rules, built once. Systems without rules have empty tables and pay
// nothing.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

struct HighEdge {
  InteractionId interaction;
  u32 rule;
};
/// An interaction that has one candidate at most stands only under rules that match that.
struct PriorityTables {
  u32 count = 0;
  static constexpr std::uint8_t kLow = 1, kHigh = 2;
  IndexVector<InteractionId, std::uint8_t> is_involved;        // on which sides of rules; empty without rules
  IndexVector<InteractionId, std::uint8_t> has_one_candidate;  // at most; the same size
  // Stands under rules, is not searched, and few others may become hidden or show with it: what its coming and going
  // changes is followed at once. The same size.
  IndexVector<InteractionId, std::uint8_t> is_followed;
  std::vector<HighEdge> high_edges;       // sorted by interaction
  RowsByInteraction high_of_interaction;  // rows of high_edges
  RowsByInteraction low_of_interaction;   // rules
  InteractionsBy interactions_of_low;     // by rule
  Csr next, previous;                     // the chain graph, by rule
  std::vector<u32> component;             // by rule: weakly connected part of the chain graph
  Csr members;                            // by component
  std::vector<std::uint8_t> cyclic;       // by component: guards alone keep it from being a cycle
};
struct RuleState {
  bool guard = false;
  bool active = false;  // it hides what it matches
  bool was_active = false;
  bool is_in_cycle = false;  // its component has one, if guards allow it
  // Enabled candidates that match its high side and, unless its component is cyclic, active rules that it chains into.
  u32 count = 0;
};

[[nodiscard]] PriorityTables link_priorities(const Tables& tables);

/// Does an interaction of the interaction's connector with these parameters (sorted) match that side of the rule?
[[nodiscard]] bool matches_low(const Tables& tables, const Priority& rule, u32 connector,
                               const std::vector<u32>& params);
[[nodiscard]] bool matches_high(const Tables& tables, const Priority& rule, u32 connector,
                                const std::vector<u32>& params);

}  // namespace bip::rt
