// Priorities between interactions: which rules hide now, kept up to date with the candidates (link/priorities.hpp has
// the tables).
//
// A rule is active if its guard holds and a chain of rules with true guards leads to an enabled high side. A change is
// followed through its part of the chain graph only: rules cost where a marked interaction, or an atom that a guard
// reads, belongs to one.
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
  /// After the marked interactions' candidates were listed: what rules make of them, into the enabled set. False: a
  /// fault.
  bool settle();
  /// Is there a rule that can hide candidates of the interaction?
  [[nodiscard]] bool can_hide(InteractionId interaction) const {
    return tables_.low_of_interaction[interaction].size != 0;
  }
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const;

 private:
  bool evaluate_rule_guards();
  bool recompute_component(u32 component);
  void contribute(u32 edge, u32 count);
  void recount(InteractionId interaction);
  void weigh(InteractionId interaction);

  CoreParts& core_;
  PriorityTables tables_;
  DirtyRows<u32> dirty_rules_;
  std::vector<RuleState> rule_states_;
  std::vector<u32> contributions_;  // by high edge: candidates of its interaction that match
  DirtyRows<u32> changed_components_;
  DirtyRows<InteractionId> reweigh_;     // interactions whose rules became active or inactive
  std::vector<u32> rule_todo_, params_;  // scratch
};

}  // namespace bip::rt
