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
  [[nodiscard]] DirtyRows& dirty() { return dirty_rules_; }
  [[nodiscard]] const DirtyRows& dirty() const { return dirty_rules_; }
  /// After the marked interactions' candidates were listed: what rules make of them, into the enabled set. False: a
  /// fault.
  bool settle();
  /// Is there a rule that can hide candidates of the interaction?
  [[nodiscard]] bool can_hide(u32 interaction) const { return tables_.low_of_interaction[interaction].size != 0; }
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const;

 private:
  bool evaluate_rule_guards();
  bool recompute_component(u32 component);
  void recount(u32 interaction);
  void weigh(u32 interaction);

  CoreParts& core_;
  PriorityTables tables_;
  DirtyRows dirty_rules_;
  std::vector<RuleState> rule_states_;
  std::vector<u32> contributions_;  // by high edge: candidates of its interaction that match
  DirtyRows changed_components_;
  DirtyRows reweigh_;                    // interactions whose rules became active or inactive
  std::vector<u32> rule_todo_, params_;  // scratch
};

}  // namespace bip::rt
