// See priority_state.hpp.
#include "runtime/core/state/priority_state.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"
#include "runtime/core/graph_algorithms.hpp"

namespace bip::rt {

void PriorityState::reset() {
  rule_states_.assign(tables_.count, {});
  contributions_.assign(tables_.high_edges.size(), 0);
  dirty_rules_.reset(tables_.count);
  for (u32 i = 0; i < tables_.count; ++i) dirty_rules_.mark(i);
  changed_components_.reset(tables_.cyclic.size());
  reweigh_.reset(tables_.is_involved.size());
}

std::size_t PriorityState::bytes() const {
  return dirty_rules_.bytes() + rule_states_.size() * sizeof(RuleState) + contributions_.size() * sizeof(u32) +
         changed_components_.bytes() + reweigh_.bytes();
}

// The rule has so many candidates of the edge's interaction on its high side.
inline void PriorityState::contribute(u32 edge, u32 count) {
  if (contributions_[edge] == count) return;
  const u32 rule = tables_.high_edges[edge].rule;
  RuleState& state = rule_states_[rule];
  const u32 before = state.high_count;
  BIP_ASSERT(before >= contributions_[edge], "rule {} counts {}, {} of them of one interaction", rule, before,
             contributions_[edge]);
  state.high_count = before - contributions_[edge] + count;
  contributions_[edge] = count;
  if ((before == 0) != (state.high_count == 0)) changed_components_.mark(tables_.component[rule]);
}

// How many candidates of the interaction match the high sides of its rules.
inline void PriorityState::recount(InteractionId interaction) {
  if ((tables_.is_involved[interaction] & PriorityTables::kHigh) == 0) return;
  const Span<u32> edges = tables_.high_of_interaction[interaction];
  const u32 candidates = core_.search.base_count(interaction);
  if (tables_.has_one_candidate[interaction] != 0) {
    // Its rules match it: link_priorities left out the others.
    for (const u32 edge : edges) contribute(edge, candidates);
    return;
  }
  const Image& image = *core_.tables.image;
  const u32 connector = core_.tables.connector_of(interaction);
  for (const u32 edge : edges) {
    u32 count = 0;
    for (u32 config = 0; config < candidates; ++config) {
      core_.search.direct_params(interaction, config, params_);
      count +=
          matches_high(core_.tables, image.priorities[tables_.high_edges[edge].rule], connector, params_) ? 1u : 0u;
    }
    contribute(edge, count);
  }
}

bool PriorityState::evaluate_rule_guards() {
  const Image& image = *core_.tables.image;
  for (u32 rule : dirty_rules_) {
    const Priority& row = image.priorities[rule];
    bool holds = true;
    if (row.guard != kNone) {
      BIP_ASSERT(row.bind_count == 0 || core_.memory.binds.rows != nullptr,
                 "rule {} reads variables that are not bound", rule);
      const Code guard = image.codes[row.guard];
      const std::int32_t status =
          guard.fn(guard.context, nullptr, core_.memory.cells.all(), core_.memory.binds.rows + row.binds);
      if (status >= 2) return core_.faults.fail_code(status, kNone, kNone, nullptr);
      holds = status != 0;
    }
    const u32 component = tables_.component[rule];
    if (holds != rule_states_[rule].guard) changed_components_.mark(component);
    rule_states_[rule].guard = holds;
  }
  dirty_rules_.clear();
  return true;
}

// Which rules of the component hide: those from which a chain of true guards reaches an enabled high side.
bool PriorityState::recompute_component(u32 component) {
  const Span<u32> members = tables_.members[component];
  const auto changed = [&](u32 rule) {
    for (const InteractionId interaction : tables_.interactions_of_low[rule]) reweigh_.mark(interaction);
  };
  if (members.size == 1 && tables_.cyclic[component] == 0) {
    // A rule that chains with no other one.
    RuleState& state = rule_states_[members[0]];
    const bool is_active = state.guard && state.high_count != 0;
    if (is_active != state.active) changed(members[0]);
    state.active = is_active;
    return true;
  }
  std::vector<u32>& todo = rule_todo_;
  todo.clear();
  if (tables_.cyclic[component] != 0) {
    // Take away true rules that no other true rule leads to; what stays is a closed cycle, or behind one.
    std::vector<u32> missing(tables_.count, 0);
    std::size_t count = 0;
    for (u32 rule : members) {
      if (!rule_states_[rule].guard) continue;
      ++count;
      for (u32 before : tables_.previous[rule]) missing[rule] += rule_states_[before].guard ? 1u : 0u;
      if (missing[rule] == 0) todo.push_back(rule);
    }
    extend_topological_order(missing, todo, [&](u32 rule, const auto& see) {
      for (u32 next : tables_.next[rule]) {
        if (rule_states_[next].guard) see(next);
      }
    });
    const bool has_cycle = todo.size() != count;
    todo.clear();
    if (has_cycle) {
      for (u32 rule : members) {
        if (rule_states_[rule].guard && missing[rule] != 0) todo.push_back(rule);
      }
      return core_.faults.fail_rules(std::vector<u32>(todo));
    }
  }
  for (u32 rule : members) {
    RuleState& state = rule_states_[rule];
    state.was_active = state.active;
    state.active = state.guard && state.high_count != 0;
    if (state.active) todo.push_back(rule);
  }
  while (!todo.empty()) {
    const u32 rule = todo.back();
    todo.pop_back();
    for (u32 before : tables_.previous[rule]) {
      RuleState& state = rule_states_[before];
      BIP_ASSERT(tables_.component[before] == component, "rule {} is of component {}", before,
                 tables_.component[before]);
      if (!state.guard || state.active) continue;
      state.active = true;
      todo.push_back(before);
    }
  }
  for (u32 rule : members) {
    if (rule_states_[rule].active != rule_states_[rule].was_active) changed(rule);
  }
  return true;
}

// Hides what active rules match and puts the rest into the enabled set.
inline void PriorityState::weigh(InteractionId interaction) {
  const u32 count = core_.search.base_count(interaction);
  if ((tables_.is_involved[interaction] & PriorityTables::kLow) == 0) {
    core_.enabled.set(interaction, count);
    return;
  }
  const Span<u32> rules = tables_.low_of_interaction[interaction];
  const bool any_active = std::any_of(rules.begin(), rules.end(), [&](u32 rule) { return rule_states_[rule].active; });
  if (tables_.has_one_candidate[interaction] != 0) {
    // As in recount: what is active hides it.
    core_.enabled.set(interaction, any_active ? 0 : count);
    return;
  }
  Listing& listing = core_.search.listing(interaction);
  listing.hidden.clear();
  if (!any_active || count == 0) {
    core_.enabled.set(interaction, count);
    return;
  }
  const Image& image = *core_.tables.image;
  const u32 connector = core_.tables.connector_of(interaction);
  u32 visible = 0;
  for (u32 config = 0; config < count; ++config) {
    core_.search.direct_params(interaction, config, params_);
    bool hidden = false;
    for (const u32 rule : rules) {
      hidden |= rule_states_[rule].active && matches_low(core_.tables, image.priorities[rule], connector, params_);
    }
    visible += hidden ? 0u : 1u;
    listing.hidden.push_back(hidden ? 1 : 0);
  }
  BIP_ASSERT(visible <= count && listing.hidden.size() == count, "{} of {} candidates", visible, count);
  core_.enabled.set(interaction, visible);
}

bool PriorityState::settle() {
  for (const InteractionId interaction : core_.ports.dirty()) recount(interaction);
  if (!evaluate_rule_guards()) return false;
  for (u32 component : changed_components_) {
    if (!recompute_component(component)) return false;
  }
  BIP_ASSERT(dirty_rules_.empty(), "guards of rules are not known");
  changed_components_.clear();
  for (const InteractionId interaction : core_.ports.dirty()) weigh(interaction);
  // Those that were marked have been weighed, unless they are held back.
  const bool all_were_weighed = !core_.partial.is_on();
  for (const InteractionId interaction : reweigh_) {
    if (!all_were_weighed || !core_.ports.dirty().has(interaction)) weigh(interaction);
  }
  reweigh_.clear();
  return true;
}

}  // namespace bip::rt
