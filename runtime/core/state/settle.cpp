// After a step: list anew the connectors that were marked, then what priorities make of it, then the enabled set.
//
// Order does not matter to the result: everything here is a function of the state. Rules cost only where a marked
// connector, or an atom that a guard reads, belongs to one; a change is followed through its part of the chain graph.
#include "runtime/core/core.hpp"

namespace bip::rt {

u32 Core::base_count(u32 interaction) const {
  if (listing_of(interaction) != kNone) return listings_[listing_of(interaction)].count;
  return values_[interaction] >= 0 ? 1 : 0;
}

bool Core::settle() {
  if (dirty_.empty() && dirty_rules_.empty()) {
    enabled_.settle_list();
    return true;
  }
  for (u32 interaction : dirty_) {
    if (listing_of(interaction) != kNone && !list(interaction)) return false;
  }
  if (rules_.count != 0) {
    if (!settle_priorities()) return false;
  } else {
    for (u32 interaction : dirty_) enabled_.set(interaction, base_count(interaction));
  }
  for (u32 interaction : dirty_) is_dirty_[interaction] = 0;
  dirty_.clear();
  enabled_.settle_list();
  return true;
}

// The parameters of a candidate; all of them unless the interaction was listed, where only `c:*` and `*:*` can match.
void Core::direct_params(u32 interaction, u32 config, std::vector<u32>& out) const {
  out.clear();
  const u32 count = tables_.connector_type(tables_.connector_of(interaction)).params.size;
  // Only connectors that are searched are told apart further.
  const u32 plan_row = listing_of(interaction) == kNone ? kNone : tables_.interactions[interaction].plan();
  if (plan_row == kNone) {
    for (u32 param = 0; param < count; ++param) out.push_back(param);
    return;
  }
  const Plan& plan = tables_.plans[plan_row];
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  const u64* bits = listings_[listing_of(interaction)].configs.data() + std::size_t{config} * plan.words;
  for (u32 param = 0; param < count; ++param) {
    const u32 node = tables_.plan_params[tables_.plan_uses[plan.first_use].first_param + param];
    if (node == kNone) continue;
    const u32 end = nodes[node].end == plan.node_count ? plan.leaves : nodes[nodes[node].end].leaf;
    bool chosen = false;
    for (u32 leaf = nodes[node].leaf; leaf < end && !chosen; ++leaf) chosen = (bits[leaf >> 6] >> (leaf & 63) & 1) != 0;
    if (chosen) out.push_back(param);
  }
}

// How many candidates of the interaction match the high sides of its rules.
void Core::recount(u32 interaction) {
  const Image& image = *tables_.image;
  const u32 connector = tables_.connector_of(interaction);
  for (u32 edge : rules_.high_of_interaction[interaction]) {
    const u32 rule = rules_.high_edges[edge].rule;
    u32 count = 0;
    for (u32 config = 0; config < base_count(interaction); ++config) {
      direct_params(interaction, config, params_);
      count += matches_high(tables_, image.priorities[rule], connector, params_) ? 1u : 0u;
    }
    RuleState& state = rule_states_[rule];
    const u32 before = state.high_count;
    state.high_count = before - contributions_[edge] + count;
    contributions_[edge] = count;
    const u32 component = rules_.component[rule];
    if ((before == 0) != (state.high_count == 0) && is_component_changed_[component] == 0) {
      is_component_changed_[component] = 1;
      changed_components_.push_back(component);
    }
  }
}

bool Core::evaluate_rule_guards() {
  const Image& image = *tables_.image;
  for (u32 rule : dirty_rules_) {
    const Priority& row = image.priorities[rule];
    bool holds = true;
    if (row.guard != kNone) {
      const Code guard = image.codes[row.guard];
      const std::int32_t status = guard.fn(guard.context, nullptr, all_.data(), binds_.rows + row.binds);
      if (status >= 2) return fail_code(status, kNone, kNone, nullptr);
      holds = status != 0;
    }
    const u32 component = rules_.component[rule];
    if (holds != rule_states_[rule].guard && is_component_changed_[component] == 0) {
      is_component_changed_[component] = 1;
      changed_components_.push_back(component);
    }
    rule_states_[rule].guard = holds;
  }
  for (u32 rule : dirty_rules_) is_rule_dirty_[rule] = 0;
  dirty_rules_.clear();
  return true;
}

// Which rules of the component hide: those from which a chain of true guards reaches an enabled high side.
bool Core::recompute_component(u32 component) {
  const Span<u32> members = rules_.members[component];
  std::vector<u32>& todo = rule_todo_;
  todo.clear();
  if (rules_.cyclic[component] != 0) {
    // Take away true rules that no other true rule leads to; what stays is a closed cycle, or behind one.
    std::vector<u32> missing(rules_.count, 0);
    u32 left = 0;
    for (u32 rule : members) {
      if (!rule_states_[rule].guard) continue;
      ++left;
      for (u32 before : rules_.previous[rule]) missing[rule] += rule_states_[before].guard ? 1u : 0u;
      if (missing[rule] == 0) todo.push_back(rule);
    }
    while (!todo.empty()) {
      const u32 rule = todo.back();
      todo.pop_back();
      --left;
      for (u32 next : rules_.next[rule]) {
        if (rule_states_[next].guard && --missing[next] == 0) todo.push_back(next);
      }
    }
    if (left != 0) {
      for (u32 rule : members) {
        if (rule_states_[rule].guard && missing[rule] != 0) todo.push_back(rule);
      }
      return fail_rules(std::vector<u32>(todo));
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
    for (u32 before : rules_.previous[rule]) {
      RuleState& state = rule_states_[before];
      if (!state.guard || state.active) continue;
      state.active = true;
      todo.push_back(before);
    }
  }
  for (u32 rule : members) {
    if (rule_states_[rule].active == rule_states_[rule].was_active) continue;
    for (u32 interaction : rules_.interactions_of_low[rule]) {
      if (is_reweighed_[interaction] != 0) continue;
      is_reweighed_[interaction] = 1;
      reweigh_.push_back(interaction);
    }
  }
  return true;
}

// Hides what active rules match and puts the rest into the enabled set.
void Core::weigh(u32 interaction) {
  const Image& image = *tables_.image;
  const u32 count = base_count(interaction);
  Listing* listing = listing_of(interaction) == kNone ? nullptr : &listings_[listing_of(interaction)];
  if (listing != nullptr) listing->hidden.clear();
  bool any_active = false;
  for (u32 rule : rules_.low_of_interaction[interaction]) any_active |= rule_states_[rule].active;
  if (!any_active || count == 0) {
    enabled_.set(interaction, count);
    return;
  }
  const u32 connector = tables_.connector_of(interaction);
  u32 visible = 0;
  for (u32 config = 0; config < count; ++config) {
    direct_params(interaction, config, params_);
    bool hidden = false;
    for (u32 rule : rules_.low_of_interaction[interaction]) {
      hidden |= rule_states_[rule].active && matches_low(tables_, image.priorities[rule], connector, params_);
    }
    visible += hidden ? 0u : 1u;
    if (listing != nullptr) listing->hidden.push_back(hidden ? 1 : 0);
  }
  enabled_.set(interaction, visible);
}

bool Core::settle_priorities() {
  for (u32 interaction : dirty_) recount(interaction);
  if (!evaluate_rule_guards()) return false;
  for (std::size_t i = 0; i < changed_components_.size(); ++i) {
    if (!recompute_component(changed_components_[i])) return false;
  }
  for (u32 component : changed_components_) is_component_changed_[component] = 0;
  changed_components_.clear();
  for (u32 interaction : dirty_) weigh(interaction);
  for (u32 interaction : reweigh_) {
    is_reweighed_[interaction] = 0;
    weigh(interaction);
  }
  reweigh_.clear();
  return true;
}

}  // namespace bip::rt
