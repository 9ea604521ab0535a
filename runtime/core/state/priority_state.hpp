// Priorities between interactions: which rules hide now, kept up to date with the candidates (link/priorities.hpp has
// the tables).
//
// A rule is active if its guard holds and a chain of rules with true guards leads to an enabled high side. So it counts
// the enabled candidates of its high side and the active rules that it chains into, and an interaction with one
// candidate counts the active rules that hide it: a change moves the counters behind it. An interaction without guards
// and choices moves them when it comes or goes (crossed), all others when their candidates are known (settle). Only
// rules whose chains may close to a cycle are looked at together.
#pragma once
#include <vector>

#include "runtime/core/link/priorities.hpp"
#include "runtime/core/state/dirty_rows.hpp"

namespace bip::rt {

struct CoreParts;

class PriorityState {
 public:
  PriorityState(CoreParts& core, const Tables& tables) : core_(core), tables_(link_priorities(tables)) {}
  [[nodiscard]] const PriorityTables& tables() const { return tables_; }
  /// To no candidates and unknown guards; every rule is marked.
  void reset();

  /// Rules whose guards must be evaluated again.
  [[nodiscard]] DirtyRows<u32>& dirty() { return dirty_rules_; }
  [[nodiscard]] const DirtyRows<u32>& dirty() const { return dirty_rules_; }
  /// Is what the interaction's coming and going changes followed by crossed(), in place of marking it?
  [[nodiscard]] bool is_followed(InteractionId interaction) const {
    return tables_.count != 0 && tables_.is_followed[interaction] != 0;
  }
  /// Such an interaction became available or unavailable: follows what that changes into the enabled set. In partial
  /// states it is marked.
  void crossed(InteractionId interaction, bool on);
  /// Is there nothing for settle() to do but for marked interactions?
  [[nodiscard]] bool is_settled() const {
    return dirty_rules_.empty() && changed_components_.empty() && reweigh_.empty();
  }
  /// After the marked interactions' candidates were listed: what rules make of them, into the enabled set. False: a
  /// fault.
  bool settle();
  /// Of an interaction with one candidate at most: do rules hide it?
  [[nodiscard]] bool is_hidden(InteractionId interaction) const {
    return tables_.count != 0 && hiding_[interaction] != 0;
  }
  /// Of a settled system: do the counters say what the candidates and the guards say? O(rules and what they match).
  [[nodiscard]] bool is_consistent() const;
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const;

 private:
  bool evaluate_rule_guards();
  bool recompute_component(u32 component);
  void contribute(u32 edge, u32 count);
  void contribute_all(InteractionId interaction, u32 count);
  void follow(u32 rule);
  void follow_chain(u32 first, bool active);
  void show_lows(u32 rule, bool active);
  void recount(InteractionId interaction);
  void weigh(InteractionId interaction);

  CoreParts& core_;
  PriorityTables tables_;
  DirtyRows<u32> dirty_rules_;
  std::vector<RuleState> rule_states_;
  std::vector<u32> contributions_;          // by high edge: candidates of its interaction that match
  IndexVector<InteractionId, u32> hiding_;  // active rules that hide candidates of it, or that may
  DirtyRows<u32> changed_components_;       // cyclic ones
  DirtyRows<InteractionId> reweigh_;        // interactions whose rules became active or inactive
  std::vector<u32> rule_todo_, params_;     // scratch
};

}  // namespace bip::rt
