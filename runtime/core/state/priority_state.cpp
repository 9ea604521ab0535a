// See priority_state.hpp.
#include "runtime/core/state/priority_state.hpp"

#include <algorithm>
#include <utility>

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"
#include "runtime/core/graph_algorithms.hpp"

namespace bip::rt {

void PriorityState::reset() {
  rule_states_.assign(tables_.count, {});
  for (u32 i = 0; i < tables_.count; ++i) rule_states_[i].is_in_cycle = tables_.cyclic[tables_.component[i]] != 0;
  contributions_.assign(tables_.high_edges.size(), 0);
  hiding_.assign(tables_.is_involved.size(), 0);
  dirty_rules_.reset(tables_.count);
  for (u32 i = 0; i < tables_.count; ++i) dirty_rules_.mark(i);
  changed_components_.reset(tables_.cyclic.size());
  reweigh_.reset(tables_.is_involved.size());
}

std::size_t PriorityState::bytes() const {
  return dirty_rules_.bytes() + rule_states_.size() * sizeof(RuleState) +
         (contributions_.size() + hiding_.size()) * sizeof(u32) + changed_components_.bytes() + reweigh_.bytes();
}

bool PriorityState::is_consistent() const {
  std::vector<u32> counts(tables_.count, 0);
  for (u32 edge = 0; edge < contributions_.size(); ++edge) {
    const InteractionId interaction = tables_.high_edges[edge].interaction;
    const bool is_one = tables_.has_one_candidate[interaction] != 0;
    if (is_one && contributions_[edge] != core_.search.base_count(interaction)) return false;
    counts[tables_.high_edges[edge].rule] += contributions_[edge];
  }
  IndexVector<InteractionId, u32> hiding(hiding_.size(), 0);
  for (u32 rule = 0; rule < tables_.count; ++rule) {
    const RuleState& state = rule_states_[rule];
    if (state.active) {
      for (const InteractionId low : tables_.interactions_of_low[rule]) ++hiding[low];
    }
    if (!state.is_in_cycle) {
      for (const u32 next : tables_.next[rule]) counts[rule] += rule_states_[next].active ? 1u : 0u;
      if (state.active != (state.guard && state.count != 0)) return false;
    }
    if (state.count != counts[rule]) return false;
  }
  return hiding == hiding_;
}

// The rule became active or inactive.
inline void PriorityState::show_lows(u32 rule, bool active) {
  for (const InteractionId low : tables_.interactions_of_low[rule]) {
    u32& hiding = hiding_[low];
    BIP_ASSERT(active || hiding != 0, "interaction {} is hidden by no rule", low);
    hiding += active ? 1u : ~0u;
    if (tables_.has_one_candidate[low] == 0) {
      reweigh_.mark(low);
    } else if (hiding == (active ? 1u : 0u)) {
      // What is searched may not be listed yet.
      if (core_.search.is_searched(low) || core_.partial.is_on()) reweigh_.mark(low);
      else core_.enabled.set(low, !active && core_.ports.is_available(low) ? 1 : 0);
    }
  }
}

// What the rule counts, or its guard, is no longer what made it active or inactive.
inline void PriorityState::follow(u32 rule) {
  RuleState& state = rule_states_[rule];
  BIP_ASSERT(!state.is_in_cycle, "rule {} is of a cycle", rule);
  const bool active = state.active = !state.active;
  if (tables_.previous[rule].size == 0) show_lows(rule, active);
  else follow_chain(rule, active);
}

// The same with the rules that chain into it. The order does not matter: all of them change in the same direction, each
// once.
void PriorityState::follow_chain(u32 first, bool active) {
  const std::size_t bottom = rule_todo_.size();
  for (u32 rule = first;; rule_todo_.pop_back()) {
    show_lows(rule, active);
    for (const u32 before : tables_.previous[rule]) {
      RuleState& state = rule_states_[before];
      BIP_ASSERT(active || state.count != 0, "rule {} counts no active rule", before);
      state.count += active ? 1u : ~0u;
      if (state.active == (state.guard && state.count != 0)) continue;
      state.active = active;
      rule_todo_.push_back(before);
    }
    if (rule_todo_.size() == bottom) return;
    rule = rule_todo_.back();
  }
}

// The rule has so many candidates of the edge's interaction on its high side.
inline void PriorityState::contribute(u32 edge, u32 count) {
  if (contributions_[edge] == count) return;
  const u32 rule = tables_.high_edges[edge].rule;
  RuleState& state = rule_states_[rule];
  const u32 before = state.count;
  BIP_ASSERT(before >= contributions_[edge], "rule {} counts {}, {} of them of one interaction", rule, before,
             contributions_[edge]);
  state.count = before - contributions_[edge] + count;
  contributions_[edge] = count;
  if ((before == 0) == (state.count == 0)) return;
  if (state.is_in_cycle) changed_components_.mark(tables_.component[rule]);
  else if (state.guard) follow(rule);
}

void PriorityState::contribute_all(InteractionId interaction, u32 count) {
  for (const u32 edge : tables_.high_of_interaction[interaction]) contribute(edge, count);
}

void PriorityState::crossed(InteractionId interaction, bool on) {
  BIP_ASSERT(is_followed(interaction), "interaction {} is not followed", interaction);
  if (core_.partial.is_on()) {
    core_.ports.mark_dirty(interaction);
    return;
  }
  // What it hides does not hide it, unless in a cycle: that is looked at in settle().
  if (hiding_[interaction] == 0) core_.enabled.set(interaction, on ? 1 : 0);
  if ((tables_.is_involved[interaction] & PriorityTables::kHigh) != 0) contribute_all(interaction, on ? 1 : 0);
}

// How many candidates of the interaction match the high sides of its rules.
inline void PriorityState::recount(InteractionId interaction) {
  if ((tables_.is_involved[interaction] & PriorityTables::kHigh) == 0) return;
  const u32 candidates = core_.search.base_count(interaction);
  if (tables_.has_one_candidate[interaction] != 0) {
    // Its rules match it: link_priorities left out the others.
    contribute_all(interaction, candidates);
    return;
  }
  const Image& image = *core_.tables.image;
  const u32 connector = core_.tables.connector_of(interaction);
  for (const u32 edge : tables_.high_of_interaction[interaction]) {
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
    RuleState& state = rule_states_[rule];
    if (holds == state.guard) continue;
    state.guard = holds;
    if (state.is_in_cycle) changed_components_.mark(tables_.component[rule]);
    else if (state.count != 0) follow(rule);
  }
  dirty_rules_.clear();
  return true;
}

// Which rules of a component that may have a cycle hide: those from which a chain of true guards reaches an enabled
// high side.
bool PriorityState::recompute_component(u32 component) {
  BIP_ASSERT(tables_.cyclic[component] != 0, "component {} has no cycle", component);
  const Span<u32> members = tables_.members[component];
  std::vector<u32>& todo = rule_todo_;
  todo.clear();
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
    return core_.faults.fail_rules(std::exchange(todo, {}));
  }
  for (u32 rule : members) {
    RuleState& state = rule_states_[rule];
    state.was_active = state.active;
    state.active = state.guard && state.count != 0;
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
    if (rule_states_[rule].active != rule_states_[rule].was_active) show_lows(rule, rule_states_[rule].active);
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
  const bool any_active = hiding_[interaction] != 0;
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
    for (const u32 rule : tables_.low_of_interaction[interaction]) {
      hidden |= rule_states_[rule].active && matches_low(core_.tables, image.priorities[rule], connector, params_);
    }
    visible += hidden ? 0u : 1u;
    listing.hidden.push_back(hidden ? 1 : 0);
  }
  BIP_ASSERT(visible <= count && listing.hidden.size() == count, "{} of {} candidates", visible, count);
  core_.enabled.set(interaction, visible);
}

bool PriorityState::settle() {
  for (const InteractionId interaction : core_.ports.dirty()) {
    if (tables_.is_involved[interaction] != 0) recount(interaction);
    else core_.enabled.set(interaction, core_.search.base_count(interaction));
  }
  if (!evaluate_rule_guards()) return false;
  for (u32 component : changed_components_) {
    if (!recompute_component(component)) return false;
  }
  BIP_ASSERT(dirty_rules_.empty(), "guards of rules are not known");
  changed_components_.clear();
  for (const InteractionId interaction : core_.ports.dirty()) {
    if (tables_.is_involved[interaction] != 0) weigh(interaction);
  }
  // Those that were marked have been weighed, unless they are held back.
  const bool all_were_weighed = !core_.partial.is_on();
  for (const InteractionId interaction : reweigh_) {
    if (!all_were_weighed || !core_.ports.dirty().has(interaction)) weigh(interaction);
  }
  reweigh_.clear();
  return true;
}

}  // namespace bip::rt
