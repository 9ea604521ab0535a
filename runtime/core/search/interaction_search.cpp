// See interaction_search.hpp.
#include "runtime/core/search/interaction_search.hpp"

#include <algorithm>
#include <set>

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"
#include "runtime/core/link/priorities.hpp"
#include "runtime/core/search/range_search.hpp"

namespace bip::rt {

namespace {
// So many guards were false before ranges are asked whether any could hold.
constexpr u32 kFirstRanges = 32;
}  // namespace

void InteractionSearch::link() {
  const Tables& tables = core_.tables;
  const u32 interaction_count = static_cast<u32>(tables.interactions.size());
  listing_of_.assign(tables.any_searched ? interaction_count : 0, kNone);
  for (const InteractionId interaction : listing_of_.ids()) {
    const InteractionInfo info = tables.interactions[interaction];
    if (!info.searched) continue;
    listing_of_[interaction] = static_cast<u32>(listings_.size());
    listings_.emplace_back();
    flat_guards_.push_back(flat_guard(info));
    is_weighted_ |= !tables.has_one_candidate(info);
  }
  u32 nodes = 0, uses = 0;
  for (const Plan& plan : tables.plans) {
    nodes = std::max(nodes, plan.node_count);
    uses = std::max(uses, plan.use_count);
  }
  BIP_ASSERT(flat_guards_.size() == listings_.size(), "{} guards of {} listings", flat_guards_.size(),
             listings_.size());
  available_.assign(nodes, 0);
  chosen_.assign(nodes, 0);
  node_scratch_.assign(nodes, 0);
  use_clause_.assign(uses, kNone);
  remembered_.link(core_);
}

void InteractionSearch::reset() {
  for (Listing& listing : listings_) listing = {};
}

u32 InteractionSearch::listed_count(u32 connector) const {
  const InteractionId interaction = core_.tables.interaction_of(connector);
  if (!interaction.is_valid()) return 0;
  // Compiled steps keep the list of the enabled alone.
  return core_.priorities.tables().count == 0 ? core_.enabled.weight(interaction) : base_count(interaction);
}

std::size_t InteractionSearch::bytes() const {
  std::size_t sum =
      listing_of_.size() * sizeof(u32) + listings_.size() * sizeof(Listing) + flat_guards_.size() * sizeof(FlatGuard);
  for (const Listing& listing : listings_) sum += listing.configs.size() * sizeof(u64) + listing.hidden.size();
  return sum + remembered_.bytes();
}

FlatGuard InteractionSearch::flat_guard(const InteractionInfo& info) {
  if (info.kind != InteractionKind::Flat || info.clause() == kNone || !core_.memory.ffi_data.empty()) return {};
  const Clause& clause = core_.tables.connector_type(info.row).clauses[info.clause()];
  const Code guard = core_.tables.code(clause.guard);
  if (guard.fn == nullptr || clause.may_fault) return {};
  const Connector& row = core_.tables.image->connectors[info.row];
  return {core_.programs.code_row(guard, core_.tables.connector_type(info.row).variables.size), row.variable(0),
          row.binds};
}

u32 InteractionSearch::base_count(InteractionId interaction) const {
  if (listing_of(interaction) != kNone) return listings_[listing_of(interaction)].count;
  return core_.ports.is_available(interaction) ? 1 : 0;
}

void InteractionSearch::direct_params(InteractionId interaction, u32 config, std::vector<u32>& out) const {
  out.clear();
  const u32 count = core_.tables.connector_type(core_.tables.connector_of(interaction)).params.size;
  // Only connectors that are searched are told apart further.
  const u32 plan_row = listing_of(interaction) == kNone ? kNone : core_.tables.interactions[interaction].plan();
  if (plan_row == kNone || core_.tables.plans[plan_row].is_listed_at_once) {
    for (u32 param = 0; param < count; ++param) out.push_back(param);
    return;
  }
  const Plan& plan = core_.tables.plans[plan_row];
  BIP_ASSERT((std::size_t{config} + 1) * plan.words <= listings_[listing_of(interaction)].configs.size(),
             "configuration {} of interaction {}", config, interaction);
  params_of_use(plan, 0, listings_[listing_of(interaction)].configs.data() + std::size_t{config} * plan.words, out);
}

// The parameters of the use's connector that take part in a configuration.
void InteractionSearch::params_of_use(const Plan& plan, u32 use_row, const u64* bits, std::vector<u32>& out) const {
  out.clear();
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  const PlanUse& use = core_.tables.plan_uses[plan.first_use + use_row];
  const u32 count = core_.tables.connector_type(use.connector).params.size;
  for (u32 param = 0; param < count; ++param) {
    const u32 node = core_.tables.plan_params[use.first_param + param];
    if (node == kNone) continue;
    const u32 end = nodes[node].end == plan.node_count ? plan.leaves : nodes[nodes[node].end].leaf;
    bool chosen = false;
    for (u32 leaf = nodes[node].leaf; leaf < end && !chosen; ++leaf) chosen = (bits[leaf >> 6] >> (leaf & 63) & 1) != 0;
    if (chosen) out.push_back(param);
  }
}

// A rendezvous: one candidate or none, as its guard says.
bool InteractionSearch::list_flat(const InteractionInfo& info, Listing& listing) {
  listing.count = 1;
  if (info.clause() == kNone) return true;
  const Connector& row = core_.tables.image->connectors[info.row];
  const Clause& clause = core_.tables.connector_type(info.row).clauses[info.clause()];
  const Code guard = core_.tables.code(clause.guard);
  core_.firing.zero_frame(info.row);
  Cell* const cells = core_.memory.cells.all();
  const std::int32_t status =
      guard.fn == nullptr ? 1
                          : guard.fn(guard.context, cells + row.first_cell, cells, core_.memory.binds.rows + row.binds);
  if (status >= 2) return core_.faults.fail_code(status, kNone, info.row, nullptr);
  listing.count = status != 0 ? 1 : 0;
  return status == 0 || !clause.may_fault || core_.firing.run_code(core_.tables.code(clause.up), info.row);
}

// A plan of one configuration, all of whose ports are enabled: its guards decide. As evaluate does for each part that
// shows only maximal interactions: a connector is not looked at if one below it has failed.
bool InteractionSearch::list_at_once(const Plan& plan, Listing& listing) {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  const bool has_parts = plan.use_count > 1 && nodes[core_.tables.plan_uses[plan.first_use + 1].link].maximal_only;
  ++search_work_.searches;
  std::fill(use_clause_.begin(), use_clause_.begin() + plan.use_count, 0u);  // 1: failed
  for (u32 i = plan.use_count; i-- > 0;) {
    const PlanUse& use = core_.tables.plan_uses[plan.first_use + i];
    if (has_parts || i + 1 == plan.use_count) ++search_work_.configurations;
    bool holds = use_clause_[i] == 0;
    if (holds) {
      ++search_work_.connectors;
      if (!evaluate_use(use, use.clause, holds)) return false;
    }
    if (holds) continue;
    if (!has_parts || i == 0) return true;
    const u32 above = nodes[use.link].parent;
    use_clause_[above == kNone ? 0 : nodes[above].use] = 1;
  }
  listing.configs.assign(plan.words, ~u64{0});
  if (plan.leaves % 64 != 0) listing.configs.back() = ~(~u64{0} << plan.leaves % 64);
  listing.count = 1;
  return true;
}

bool InteractionSearch::list(InteractionId interaction) {
  BIP_ASSERT(is_searched(interaction), "interaction {} is not searched", interaction);
  Listing& listing = listings_[listing_of(interaction)];
  listing.count = 0;
  listing.configs.clear();
  if (!core_.ports.is_available(interaction)) return true;
  if (const FlatGuard& guard = flat_guards_[listing_of(interaction)]; guard.code != kNone) {
    const ProgramCode& code = core_.programs.code(guard.code);
    Cell* own = core_.memory.cells.from(guard.own);
    for (u32 i = 0; i < code.zeroed; ++i) own[i] = Cell{0};
    const std::int32_t status =
        code.code.fn(code.code.context, own, core_.memory.cells.all(), core_.memory.binds.rows + guard.binds);
    if (status >= 2) return core_.faults.fail_code(status, kNone, core_.tables.connector_of(interaction), nullptr);
    listing.count = status != 0 ? 1 : 0;
    return true;
  }
  const InteractionInfo info = core_.tables.interactions[interaction];
  if (info.kind == InteractionKind::Flat) return list_flat(info, listing);
  const Plan& plan = core_.tables.plans[info.plan()];
  if (plan.is_listed_at_once) return list_at_once(plan, listing);
  if (const std::vector<u64>* known = remembered_.recall(core_, info.plan())) {
    ++search_work_.recalled;
    listing.configs = *known;
    listing.count = static_cast<u32>(known->size() / plan.words);
    return true;
  }
  std::vector<Bits> found;
  ++search_work_.searches;
  // Data have changed since.
  evaluated_.forget(plan);
  if (!search_links(plan)) return false;
  const bool listed = core_.options.progress == MaximalProgress::Off ? enumerate(plan, found) : search(plan, 0, found);
  link_alternatives_.clear();
  if (!listed) return false;
  hide_by_inner_rules(plan, 0, found);
  for (const Bits& bits : found) listing.configs.insert(listing.configs.end(), bits.begin(), bits.end());
  listing.count = static_cast<u32>(found.size());
  BIP_ASSERT(listing.configs.size() == found.size() * plan.words, "{} words of {} configurations",
             listing.configs.size(), found.size());
  remembered_.keep(info.plan(), listing.configs);
  return true;
}

u32 InteractionSearch::chosen_alternative(const Plan& plan, u32 choice) const {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  u32 child = choice + 1;
  BIP_ASSERT(nodes[choice].kind == NodeKind::Choice && chosen_[choice] != 0, "node {} is no chosen Choice", choice);
  while (chosen_[child] == 0) child = nodes[child].end;
  BIP_ASSERT(child < nodes[choice].end, "no alternative of node {} is chosen", choice);
  return child;
}

// Lets the parameters that are bound to merged ports name the variables of the chosen alternatives.
void InteractionSearch::bind_choices(const Plan& plan, const PlanUse& use) {
  const Image& image = *core_.tables.image;
  const ConnectorType& type = core_.tables.connector_type(use.connector);
  for (u32 param = 0; param < type.params.size; ++param) {
    const u32 node = core_.tables.plan_params[use.first_param + param];
    const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
    if (node == kNone || nodes[node].kind != NodeKind::Choice || chosen_[node] == 0) continue;
    const PlanNode& chosen = nodes[chosen_alternative(plan, node)];
    u32* row = core_.memory.binds.own.data() + image.connectors[use.connector].binds + type.params[param].first_bind;
    if (chosen.kind == NodeKind::Leaf) {
      const u32 atom = core_.tables.port_atom[chosen.ref];
      const Port& port = core_.tables.atom_type(atom).ports[chosen.ref - core_.tables.port_base(atom)];
      for (u32 variable : port.variables) *row++ = (core_.atoms[atom].first_cell + variable).value;
    } else {
      for (u32 variable : core_.tables.connector_type(chosen.ref).export_variables)
        *row++ = image.connectors[chosen.ref].first_cell + variable;
    }
  }
}

void InteractionSearch::choose(const Candidate& candidate, const Plan& plan) {
  if (listing_of(candidate.interaction) != kNone) {
    BIP_ASSERT(candidate.config < listing(candidate.interaction).count, "configuration {} of {}", candidate.config,
               listing(candidate.interaction).count);
    if (!plan.is_listed_at_once) {
      choose_bits(plan, listings_[listing_of(candidate.interaction)].configs.data() +
                            std::size_t{candidate.config} * plan.words);
      return;
    }
  }
  if (plan.rigid) {
    std::fill(chosen_.begin(), chosen_.begin() + plan.node_count, std::uint8_t{1});
    return;
  }
  look_at_availability(plan, 0);
  choose_largest(plan, 0);
}

Span<u64> InteractionSearch::choice_key(const Candidate& candidate, const Plan& plan) {
  if (const u32 row = listing_of(candidate.interaction); row != kNone) {
    BIP_ASSERT(candidate.config < listings_[row].count, "configuration {} of {}", candidate.config,
               listings_[row].count);
    return {listings_[row].configs.data() + std::size_t{candidate.config} * plan.words, plan.words};
  }
  key_.assign(plan.words, 0);
  // All ports take part in a rigid plan.
  if (plan.rigid) return {key_.data(), plan.words};
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  for (u32 i = 0; i < plan.node_count; ++i) {
    const PlanNode& node = nodes[i];
    if (node.kind == NodeKind::Leaf && core_.ports.enabled_row(node.ref) != kNone)
      key_[node.leaf >> 6] |= u64{1} << (node.leaf & 63);
  }
  return {key_.data(), plan.words};
}

bool InteractionSearch::run_ups(const Plan& plan) {
  // Parents come before children in a plan: backwards is bottom up.
  for (u32 i = plan.use_count; i-- > 0;) {
    const PlanUse& use = core_.tables.plan_uses[plan.first_use + i];
    BIP_ASSERT(use.link == kNone || use.link < use.root, "use {} comes before its link", i);
    if (chosen_[use.root] == 0) continue;
    core_.firing.zero_frame(use.connector);
    if (use.has_choice) bind_choices(plan, use);
    const u32 row = chosen_clause(plan, i);
    use_clause_[i] = row;
    if (row == kNone) continue;
    if (!core_.firing.run_code(core_.tables.code(core_.tables.connector_type(use.connector).clauses[row].up),
                               use.connector))
      return false;
  }
  return true;
}

void InteractionSearch::look_at_availability(const Plan& plan, u32 root) {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  const u32 end = nodes[root].end;
  for (u32 i = root; i < end; ++i) node_scratch_[i] = 0;
  for (u32 i = end; i-- > root;) {
    const PlanNode& node = nodes[i];
    bool available = false;
    switch (node.kind) {
      case NodeKind::Leaf: available = core_.ports.enabled_row(node.ref) != kNone; break;
      case NodeKind::Link:
        available = node_scratch_[i] != 0 &&
                    (!node.maximal_only || link_alternatives_.empty() || !link_alternatives_[i].empty());
        break;
      case NodeKind::Choice:
        available = node_scratch_[i] != 0 && (link_alternatives_.empty() || !link_alternatives_[i].empty());
        break;
      case NodeKind::Group:
        available = node.has_trigger ? node_scratch_[i] != 0 : node.children != 0 && node_scratch_[i] == node.children;
        break;
    }
    available_[i] = available ? 1 : 0;
    if (!available || i == root) continue;
    BIP_ASSERT(node.parent >= root && node.parent < i, "node {} below node {}", i, node.parent);
    const PlanNode& parent = nodes[node.parent];
    if (!parent.has_trigger || node.trigger) ++node_scratch_[node.parent];
  }
}

void InteractionSearch::choose_largest(const Plan& plan, u32 root) {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  chosen_[root] = available_[root];
  for (u32 i = root + 1; i < nodes[root].end; ++i) chosen_[i] = chosen_[nodes[i].parent] & available_[i];
}

void InteractionSearch::choose_bits(const Plan& plan, const u64* bits) {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  std::fill(chosen_.begin(), chosen_.begin() + plan.node_count, std::uint8_t{0});
  for (u32 i = plan.node_count; i-- > 0;) {
    const PlanNode& node = nodes[i];
    if (node.kind == NodeKind::Leaf) chosen_[i] = bits[node.leaf >> 6] >> (node.leaf & 63) & 1;
    if (chosen_[i] != 0 && node.parent != kNone) chosen_[node.parent] = 1;
  }
  BIP_ASSERT(plan.leaves % 64 == 0 || bits[plan.words - 1] >> plan.leaves % 64 == 0, "a bit beyond the {} leaves",
             plan.leaves);
}

void InteractionSearch::bits_of_choice(const Plan& plan, Bits& bits) const {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  bits.assign(plan.words, 0);
  for (u32 i = 0; i < plan.node_count; ++i) {
    const u32 leaf = nodes[i].leaf;
    if (nodes[i].kind == NodeKind::Leaf && chosen_[i] != 0) bits[leaf >> 6] |= u64{1} << (leaf & 63);
  }
}

u32 InteractionSearch::chosen_clause(const Plan& plan, u32 use_row) {
  const PlanUse& use = core_.tables.plan_uses[plan.first_use + use_row];
  if (plan.rigid) return use.clause;
  const u32 type_row = core_.tables.image->connectors[use.connector].type;
  if (core_.tables.clause_order[type_row].size == 0) return kNone;
  params_.clear();
  for (u32 param = 0; param < core_.tables.image->connector_types[type_row].params.size; ++param) {
    const u32 node = core_.tables.plan_params[use.first_param + param];
    if (node != kNone && chosen_[node] != 0) params_.push_back(param);
  }
  return core_.tables.clause_of(type_row, {params_.data(), static_cast<u32>(params_.size())});
}

// The guard of a clause (or kNone) of the use's connector, and its `up` if that holds. False: a fault.
inline bool InteractionSearch::evaluate_use(const PlanUse& use, u32 clause_row, bool& holds) {
  core_.firing.zero_frame(use.connector);
  if (clause_row == kNone) return true;
  const Clause& clause = core_.tables.connector_type(use.connector).clauses[clause_row];
  const Code guard = core_.tables.code(clause.guard);
  if (guard.fn != nullptr) {
    const Connector& connector = core_.tables.image->connectors[use.connector];
    const std::int32_t status = guard.fn(guard.context, core_.memory.cells.from(connector.variable(0)),
                                         core_.memory.cells.all(), core_.memory.binds.rows + connector.binds);
    if (status >= 2) return core_.faults.fail_code(status, kNone, use.connector, nullptr);
    holds = status != 0;
    if (!holds) return true;
  }
  return core_.firing.run_code(core_.tables.code(clause.up), use.connector);
}

// Guards and `up`s of the choice below root, bottom up. failed: the use whose guard is false, or kNone. False: a fault.
bool InteractionSearch::evaluate(const Plan& plan, u32 root, const Bits& bits, u32& failed) {
  // What a use computes follows from its sub-choice, and is still in its frame.
  const bool remembers = plan.is_tree && !plan.has_choice;
  ++search_work_.configurations;
  const u32 end = core_.tables.plan_nodes[plan.first_node + root].end;
  failed = kNone;
  for (u32 i = plan.use_count; i-- > 0;) {
    const PlanUse& use = core_.tables.plan_uses[plan.first_use + i];
    if (use.root < root || use.root >= end || chosen_[use.root] == 0) continue;
    if (remembers) {
      if (evaluated_.knows(plan, i, use, bits.data())) {
        if (evaluated_.uses[i].holds) continue;
        failed = i;
        return true;
      }
    }
    ++search_work_.connectors;
    if (use.has_choice) bind_choices(plan, use);
    bool holds = true;
    if (!evaluate_use(use, chosen_clause(plan, i), holds)) return false;
    if (holds) continue;
    if (remembers) evaluated_.uses[i].holds = false;
    failed = i;
    return true;
  }
  return true;
}

namespace {

// Canonical order: at the first leaf in which two configurations differ, the one that has it comes first.
bool comes_first(const Bits& a, const Bits& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const u64 difference = a[i] ^ b[i];
    if (difference != 0) return (a[i] & (difference & (0 - difference))) != 0;
  }
  return false;
}
Bits without(const Bits& bits, u32 first_leaf, u32 last_leaf) {
  Bits result = bits;
  for (u32 leaf = first_leaf; leaf < last_leaf; ++leaf) result[leaf >> 6] &= ~(u64{1} << (leaf & 63));
  return result;
}
void keep_maximal(std::vector<Bits>& found) {
  SetsBySize all;
  for (const Bits& bits : found) all.add(bits);
  std::erase_if(found, [&](const Bits& bits) { return all.has_larger(bits); });
  std::sort(found.begin(), found.end(), comes_first);
}

}  // namespace

// The largest available configurations below root: one, unless merged ports or parameters that show only their maximal
// interactions have several; then each combination of those.
bool InteractionSearch::initial_configurations(const Plan& plan, u32 root, std::vector<Bits>& out) {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  look_at_availability(plan, root);
  if (available_[root] == 0) return true;
  std::fill(chosen_.begin(), chosen_.begin() + plan.node_count, std::uint8_t{0});
  choose_largest(plan, root);
  std::vector<u32> links;
  for (u32 i = root; i < nodes[root].end;) {
    if (nodes[i].maximal_only && chosen_[i] != 0) {
      links.push_back(i);
      for (u32 j = i + 1; j < nodes[i].end; ++j) chosen_[j] = 0;
      i = nodes[i].end;
    } else {
      ++i;
    }
  }
  Bits base;
  bits_of_choice(plan, base);
  BIP_ASSERT(base.size() == plan.words && out.empty(), "{} words of {}", base.size(), plan.words);
  out.push_back(base);
  for (u32 link : links) {
    const std::vector<Bits>& alternatives = link_alternatives_[link];
    if (out.size() * alternatives.size() > core_.options.enumeration_bound) {
      return core_.faults.fail_connector(FaultCode::TooManyInteractions, plan.connector);
    }
    std::vector<Bits> combined;
    for (const Bits& bits : out) {
      for (const Bits& alternative : alternatives) {
        combined.push_back(bits);
        for (std::size_t w = 0; w < bits.size(); ++w) combined.back()[w] |= alternative[w];
      }
    }
    out = std::move(combined);
  }
  return true;
}

// The next smaller configurations once the guard of use `failed` is false. chosen_ holds `bits`.
void InteractionSearch::smaller(const Plan& plan, u32 root, u32 failed, const Bits& bits, std::vector<Bits>& out) {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  const u32 top = core_.tables.plan_uses[plan.first_use + failed].root;
  const auto leaf_end = [&](u32 node) {
    return nodes[node].end == plan.node_count ? plan.leaves : nodes[nodes[node].end].leaf;
  };
  // Chosen triggers of each group from the search's root on: a trigger may go if another one stays.
  std::vector<u32> triggers(plan.node_count, 0);
  for (u32 i = root + 1; i < nodes[root].end; ++i) {
    if (chosen_[i] != 0 && nodes[i].trigger) ++triggers[nodes[i].parent];
  }
  const auto droppable = [&](u32 node) {
    return nodes[nodes[node].parent].has_trigger && (!nodes[node].trigger || triggers[nodes[node].parent] > 1);
  };
  // Backwards: is a node's sub-choice minimal? What shows only its maximal interactions goes as a whole.
  std::vector<std::uint8_t> shrinks(plan.node_count, 0), rigid(plan.node_count, 0);
  for (u32 i = top + 1; i < nodes[top].end; ++i) {
    const PlanNode& parent = nodes[nodes[i].parent];
    // Below a choice only what a Link that is not maximal_only leads to can shrink.
    rigid[i] = rigid[nodes[i].parent] | (parent.kind == NodeKind::Link && parent.maximal_only ? 1 : 0);
  }
  for (u32 i = nodes[top].end; i-- > top + 1;) {
    if (chosen_[i] == 0 || rigid[i] != 0) continue;
    if (shrinks[i] != 0) {
      shrinks[nodes[i].parent] = 1;
    } else if (droppable(i)) {
      shrinks[nodes[i].parent] = 1;
      out.push_back(without(bits, nodes[i].leaf, leaf_end(i)));
    }
  }
  if (shrinks[top] != 0) return;
  // The largest configuration without the failed use.
  for (u32 i = top; i != root; i = nodes[i].parent) {
    if (!droppable(i)) continue;
    out.push_back(without(bits, nodes[i].leaf, leaf_end(i)));
    return;
  }
}

bool InteractionSearch::search(const Plan& plan, u32 root, std::vector<Bits>& found) {
  std::vector<Bits> todo;
  if (!initial_configurations(plan, root, todo)) return false;
  const std::vector<Bits> largest = plan.has_ranges ? todo : std::vector<Bits>();
  std::set<Bits> seen;
  SetsBySize enabled;  // those found
  while (!todo.empty()) {
    const Bits bits = std::move(todo.back());
    todo.pop_back();
    if (enabled.covers(bits)) continue;
    choose_bits(plan, bits.data());
    u32 failed = kNone;
    if (!evaluate(plan, root, bits, failed)) return false;
    if (failed == kNone) {
      found.push_back(bits);
      enabled.add(bits);
      continue;
    }
    BIP_ASSERT(failed < plan.use_count, "use {} of {}", failed, plan.use_count);
    if (!seen.insert(bits).second) continue;
    if (plan.has_ranges && found.empty() && seen.size() == std::min(kFirstRanges, core_.options.descent_bound) &&
        !may_hold(plan, root, largest))
      return true;
    if (plan.has_ranges && seen.size() > core_.options.descent_bound) {
      if (!search_ranges(plan, root, largest, enabled, found)) return false;
      break;
    }
    if (seen.size() > std::size_t{core_.options.enumeration_bound} * 16) {
      return core_.faults.fail_connector(FaultCode::TooManyInteractions, plan.connector);
    }
    smaller(plan, root, failed, bits, todo);
  }
  if (found.size() > 1) keep_maximal(found);
  BIP_ASSERT(std::adjacent_find(found.begin(), found.end()) == found.end(), "one of {} configurations twice",
             found.size());
  return true;
}

// The alternatives of merged ports and of parameters bound through a compound's exported port, inner ones first.
bool InteractionSearch::search_links(const Plan& plan) {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  link_alternatives_.assign(plan.node_count, {});
  witness_configs_.assign(plan.witnesses.size(), {});
  inner_active_.assign(plan.witnesses.empty() ? 0 : core_.tables.image->priorities.size, 0);
  u32 witness = static_cast<u32>(plan.witnesses.size());
  for (u32 i = plan.node_count; i-- > 0;) {
    if (witness != 0 && plan.witnesses[witness - 1].root == i) {
      --witness;
      if (!search(plan, i, witness_configs_[witness])) return false;
      const bool is_first = witness == 0 || plan.witnesses[witness - 1].group != plan.witnesses[witness].group;
      if (is_first && !decide_inner_rules(plan, witness)) return false;
    }
    if (!nodes[i].maximal_only) continue;
    std::vector<Bits> found;
    if (nodes[i].kind == NodeKind::Link) {
      if (!search(plan, i + 1, found)) return false;
      hide_by_inner_rules(plan, nodes[i].use, found);
    } else if (!choice_alternatives(plan, i, found)) {
      return false;
    }
    link_alternatives_[i] = std::move(found);
  }
  return true;
}

// Which rules of the group hide: those with a true guard from which a chain of such rules leads to an interaction that
// a member of the group offers. A chain that closes is reported when the rules' guards are settled
// (priority_state.hpp).
bool InteractionSearch::decide_inner_rules(const Plan& plan, u32 first_witness) {
  const Image& image = *core_.tables.image;
  const u32 group = plan.witnesses[first_witness].group;
  std::vector<std::uint8_t> holds(image.priorities.size, 0);
  std::vector<u32> todo;
  for (const u32 rule : core_.tables.inner_rules.groups[group].rules) {
    const Priority& row = image.priorities[rule];
    holds[rule] = 1;
    if (row.guard != kNone) {
      const Code guard = image.codes[row.guard];
      const std::int32_t status =
          guard.fn(guard.context, nullptr, core_.memory.cells.all(), core_.memory.binds.rows + row.binds);
      if (status >= 2) return core_.faults.fail_code(status, kNone, kNone, nullptr);
      holds[rule] = status != 0 ? 1 : 0;
    }
    bool is_met = false;
    for (u32 w = first_witness; w < plan.witnesses.size() && plan.witnesses[w].group == group && holds[rule] != 0;
         ++w) {
      for (const Bits& bits : witness_configs_[w]) {
        params_of_use(plan, plan.witnesses[w].use, bits.data(), params_);
        is_met = is_met || matches_high(core_.tables, row, plan.witnesses[w].connector, params_);
      }
    }
    if (!is_met) continue;
    inner_active_[rule] = 1;
    todo.push_back(rule);
  }
  while (!todo.empty()) {
    const u32 rule = todo.back();
    todo.pop_back();
    for (const u32 before : core_.priorities.tables().previous[rule]) {
      if (holds[before] == 0 || inner_active_[before] != 0) continue;
      inner_active_[before] = 1;
      todo.push_back(before);
    }
  }
  return true;
}

// Takes away what rules of the connector's own compound hide.
void InteractionSearch::hide_by_inner_rules(const Plan& plan, u32 use, std::vector<Bits>& found) {
  if (plan.witnesses.empty()) return;
  const u32 connector = core_.tables.plan_uses[plan.first_use + use].connector;
  const u32 group = core_.tables.inner_rules.of_connector(connector);
  if (group == kNone) return;
  std::erase_if(found, [&](const Bits& bits) {
    params_of_use(plan, use, bits.data(), params_);
    const std::vector<u32>& rules = core_.tables.inner_rules.groups[group].rules;
    return std::any_of(rules.begin(), rules.end(), [&](u32 rule) {
      return inner_active_[rule] != 0 &&
             matches_low(core_.tables, core_.tables.image->priorities[rule], connector, params_);
    });
  });
}

// Those of its ports, in their order: what differs between them differs in leaves.
bool InteractionSearch::choice_alternatives(const Plan& plan, u32 choice, std::vector<Bits>& found) {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  for (u32 child = choice + 1; child < nodes[choice].end; child = nodes[child].end) {
    if (nodes[child].kind == NodeKind::Leaf) {
      if (core_.ports.enabled_row(nodes[child].ref) == kNone) continue;
      found.emplace_back(plan.words, 0);
      found.back()[nodes[child].leaf >> 6] |= u64{1} << (nodes[child].leaf & 63);
    } else if (nodes[child].maximal_only) {
      found.insert(found.end(), link_alternatives_[child].begin(), link_alternatives_[child].end());
    } else {
      std::vector<Bits> largest;
      if (!initial_configurations(plan, child + 1, largest)) return false;
      found.insert(found.end(), largest.begin(), largest.end());
    }
  }
  return true;
}

// All enabled configurations: the choices of each node as a list, bottom up, then the guards.
bool InteractionSearch::enumerate(const Plan& plan, std::vector<Bits>& found) {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  look_at_availability(plan, 0);
  const auto too_many = [&] { return core_.faults.fail_connector(FaultCode::TooManyInteractions, plan.connector); };
  std::vector<std::vector<Bits>> choices(plan.node_count);
  for (u32 i = nodes[0].end; i-- > 0;) {
    const PlanNode& node = nodes[i];
    if (available_[i] == 0) continue;
    if (node.kind == NodeKind::Leaf) {
      Bits bits(plan.words, 0);
      bits[node.leaf >> 6] |= u64{1} << (node.leaf & 63);
      choices[i].push_back(std::move(bits));
      continue;
    }
    if (node.kind == NodeKind::Link) {
      choices[i] = node.maximal_only ? link_alternatives_[i] : std::move(choices[i + 1]);
      continue;
    }
    if (node.kind == NodeKind::Choice) {
      for (u32 child = i + 1; child < node.end; child = nodes[child].end) {
        choices[i].insert(choices[i].end(), choices[child].begin(), choices[child].end());
        choices[child].clear();
      }
      continue;
    }
    // Two lists: without and with a trigger.
    std::vector<Bits> plain(1, Bits(plan.words, 0)), triggered;
    for (u32 child = i + 1; child < node.end; child = nodes[child].end) {
      const bool optional = node.has_trigger;
      std::vector<Bits> plain_now, triggered_now;
      if (optional) {
        plain_now = plain;
        triggered_now = triggered;
      }
      const u64 product = static_cast<u64>(plain.size() + triggered.size()) * (choices[child].size() + 1);
      if (product > core_.options.enumeration_bound) return too_many();
      const auto join = [&](const std::vector<Bits>& from, std::vector<Bits>& to) {
        for (const Bits& left : from) {
          for (const Bits& right : choices[child]) {
            to.push_back(left);
            for (std::size_t w = 0; w < left.size(); ++w) to.back()[w] |= right[w];
          }
        }
      };
      join(plain, optional && nodes[child].trigger ? triggered_now : plain_now);
      join(triggered, triggered_now);
      plain = std::move(plain_now);
      triggered = std::move(triggered_now);
      choices[child].clear();
    }
    choices[i] = node.has_trigger ? std::move(triggered) : std::move(plain);
  }
  for (const Bits& bits : choices[0]) {
    choose_bits(plan, bits.data());
    u32 failed = kNone;
    if (!evaluate(plan, 0, bits, failed)) return false;
    if (failed == kNone) found.push_back(bits);
  }
  std::sort(found.begin(), found.end(), comes_first);
  BIP_ASSERT(std::adjacent_find(found.begin(), found.end()) == found.end(), "one of {} configurations twice",
             found.size());
  return true;
}

// Could a configuration within one of these be enabled?
bool InteractionSearch::may_hold(const Plan& plan, u32 root, const std::vector<Bits>& largest) {
  RangeSearch search(core_.tables, plan, root, core_.memory.cells.all(), core_.memory.binds.rows);
  return std::any_of(largest.begin(), largest.end(), [&](const Bits& bits) {
    ++search_work_.range_looks;
    search.start(bits);
    return search.look();
  });
}

// Adds enabled configurations within these, the maximal ones among them, to those that were found.
bool InteractionSearch::search_ranges(const Plan& plan, u32 root, const std::vector<Bits>& largest, SetsBySize& enabled,
                                      std::vector<Bits>& found) {
  RangeSearch search(core_.tables, plan, root, core_.memory.cells.all(), core_.memory.binds.rows);
  u64 looks = 0;
  for (const Bits& from : largest) {
    search.start(from);
    bool goes_on = true;
    while (goes_on) {
      if (++looks > u64{core_.options.enumeration_bound} * 16)
        return core_.faults.fail_connector(FaultCode::TooManyInteractions, plan.connector);
      ++search_work_.range_looks;
      bool is_open = search.look();
      if (is_open) {
        const Bits bits = search.largest();
        is_open = !enabled.covers(bits);
        if (is_open) {
          choose_bits(plan, bits.data());
          u32 failed = kNone;
          if (!evaluate(plan, root, bits, failed)) return false;
          if (failed == kNone) {
            if (found.size() == core_.options.enumeration_bound)
              return core_.faults.fail_connector(FaultCode::TooManyInteractions, plan.connector);
            found.push_back(bits);
            enabled.add(bits);
            is_open = false;
          }
        }
      }
      goes_on = (is_open && search.decide()) || search.next();
    }
  }
  return true;
}

}  // namespace bip::rt
