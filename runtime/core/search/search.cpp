// Which configurations of a connector with guards are candidates: the maximal enabled ones.
//
// Downward from the largest available configuration. Connectors of the tree are evaluated bottom up (guard, then `up`
// into the connector's own frame). If a guard fails for a sub-choice, every configuration with the same sub-choice
// fails, so only configurations that change it are looked at next: one step smaller, or without it where it cannot
// shrink. Enabled ones stop the descent. With k guarded clauses this looks at O(k * ports) configurations where guards
// are independent; where data of a hierarchy decide and the descent goes on for long, search_ranges.cpp goes on from
// above with bounds (a limit turns what is inherently exponential into a fault). From one configuration to the next a
// connector is evaluated again only if its own sub-choice is another one: in a tree those above what went.
#include <algorithm>
#include <set>

#include "runtime/core/core.hpp"

namespace bip::rt {

namespace {
// So many guards were false before ranges are asked whether any could hold.
constexpr u32 kFirstRanges = 32;
}  // namespace

void Core::look_at_availability(const Plan& plan, u32 root) {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  const u32 end = nodes[root].end;
  for (u32 i = root; i < end; ++i) node_scratch_[i] = 0;
  for (u32 i = end; i-- > root;) {
    const PlanNode& node = nodes[i];
    bool available = false;
    switch (node.kind) {
      case NodeKind::Leaf: available = enabled_row(node.ref) != kNone; break;
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
    const PlanNode& parent = nodes[node.parent];
    if (!parent.has_trigger || node.trigger) ++node_scratch_[node.parent];
  }
}

void Core::choose_largest(const Plan& plan, u32 root) {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  chosen_[root] = available_[root];
  for (u32 i = root + 1; i < nodes[root].end; ++i) chosen_[i] = chosen_[nodes[i].parent] & available_[i];
}

void Core::choose_bits(const Plan& plan, const u64* bits) {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  std::fill(chosen_.begin(), chosen_.begin() + plan.node_count, std::uint8_t{0});
  for (u32 i = plan.node_count; i-- > 0;) {
    const PlanNode& node = nodes[i];
    if (node.kind == NodeKind::Leaf) chosen_[i] = bits[node.leaf >> 6] >> (node.leaf & 63) & 1;
    if (chosen_[i] != 0 && node.parent != kNone) chosen_[node.parent] = 1;
  }
}

void Core::bits_of_choice(const Plan& plan, Bits& bits) const {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  bits.assign(plan.words, 0);
  for (u32 i = 0; i < plan.node_count; ++i) {
    const u32 leaf = nodes[i].leaf;
    if (nodes[i].kind == NodeKind::Leaf && chosen_[i] != 0) bits[leaf >> 6] |= u64{1} << (leaf & 63);
  }
}

u32 Core::chosen_clause(const Plan& plan, u32 use_row) {
  const PlanUse& use = tables_.plan_uses[plan.first_use + use_row];
  if (plan.rigid) return use.clause;
  const u32 type_row = tables_.image->connectors[use.connector].type;
  if (tables_.clause_order[type_row].empty()) return kNone;
  params_.clear();
  for (u32 param = 0; param < tables_.image->connector_types[type_row].params.size; ++param) {
    const u32 node = tables_.plan_params[use.first_param + param];
    if (node != kNone && chosen_[node] != 0) params_.push_back(param);
  }
  return tables_.clause_of(type_row, {params_.data(), static_cast<u32>(params_.size())});
}

// Guards and `up`s of the choice below root, bottom up. failed: the use whose guard is false, or kNone. False: a fault.
bool Core::evaluate(const Plan& plan, u32 root, const Bits& bits, u32& failed) {
  // What a use computes follows from its sub-choice, and is still in its frame.
  const bool remembers = plan.is_tree && !plan.has_choice;
  ++search_work_.configurations;
  const u32 end = tables_.plan_nodes[plan.first_node + root].end;
  failed = kNone;
  for (u32 i = plan.use_count; i-- > 0;) {
    const PlanUse& use = tables_.plan_uses[plan.first_use + i];
    if (use.root < root || use.root >= end || chosen_[use.root] == 0) continue;
    if (remembers) {
      if (evaluated_.knows(plan, i, use, bits.data())) {
        if (evaluated_.uses[i].holds) continue;
        failed = i;
        return true;
      }
    }
    ++search_work_.connectors;
    zero_frame(use.connector);
    if (use.has_choice) bind_choices(plan, use);
    const u32 row = chosen_clause(plan, i);
    if (row == kNone) continue;
    const Clause& clause = tables_.connector_type(use.connector).clauses[row];
    const Code guard = tables_.code(clause.guard);
    if (guard.fn != nullptr) {
      const Connector& connector = tables_.image->connectors[use.connector];
      const std::int32_t status =
          guard.fn(guard.context, all_.data() + connector.first_cell, all_.data(), binds_.rows + connector.binds);
      if (status >= 2) return fail_code(status, kNone, use.connector, nullptr);
      if (status == 0) {
        if (remembers) evaluated_.uses[i].holds = false;
        failed = i;
        return true;
      }
    }
    if (!run_code(tables_.code(clause.up), use.connector)) return false;
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
  std::vector<Bits> kept;
  for (std::size_t i = 0; i < found.size(); ++i) {
    bool dominated = false;
    for (std::size_t j = 0; j < found.size() && !dominated; ++j) {
      dominated = i != j && contains(found[j], found[i]) && found[j] != found[i];
    }
    if (!dominated) kept.push_back(found[i]);
  }
  std::sort(kept.begin(), kept.end(), comes_first);
  found = std::move(kept);
}

}  // namespace

// The largest available configurations below root: one, unless merged ports or parameters that show only their maximal
// interactions have several; then each combination of those.
bool Core::initial_configurations(const Plan& plan, u32 root, std::vector<Bits>& out) {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
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
  out.push_back(base);
  for (u32 link : links) {
    const std::vector<Bits>& alternatives = link_alternatives_[link];
    if (out.size() * alternatives.size() > options_.enumeration_bound) {
      return fail_connector(FaultCode::TooManyInteractions, plan.connector);
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
void Core::smaller(const Plan& plan, u32 root, u32 failed, const Bits& bits, std::vector<Bits>& out) {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  const u32 top = tables_.plan_uses[plan.first_use + failed].root;
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

bool Core::search(const Plan& plan, u32 root, std::vector<Bits>& found) {
  std::vector<Bits> todo;
  if (!initial_configurations(plan, root, todo)) return false;
  const std::vector<Bits> largest = plan.has_ranges ? todo : std::vector<Bits>();
  std::set<Bits> seen;
  while (!todo.empty()) {
    const Bits bits = std::move(todo.back());
    todo.pop_back();
    const bool below = std::any_of(found.begin(), found.end(), [&](const Bits& big) { return contains(big, bits); });
    if (below) continue;
    choose_bits(plan, bits.data());
    u32 failed = kNone;
    if (!evaluate(plan, root, bits, failed)) return false;
    if (failed == kNone) {
      found.push_back(bits);
      continue;
    }
    if (!seen.insert(bits).second) continue;
    if (plan.has_ranges && found.empty() && seen.size() == std::min(kFirstRanges, options_.descent_bound) &&
        !may_hold(plan, root, largest))
      return true;
    if (plan.has_ranges && seen.size() > options_.descent_bound) {
      if (!search_ranges(plan, root, largest, found)) return false;
      break;
    }
    if (seen.size() > std::size_t{options_.enumeration_bound} * 16) {
      return fail_connector(FaultCode::TooManyInteractions, plan.connector);
    }
    smaller(plan, root, failed, bits, todo);
  }
  if (found.size() > 1) keep_maximal(found);
  return true;
}

// The alternatives of merged ports and of parameters bound through a compound's exported port, inner ones first.
bool Core::search_links(const Plan& plan) {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  link_alternatives_.assign(plan.node_count, {});
  for (u32 i = plan.node_count; i-- > 0;) {
    if (!nodes[i].maximal_only) continue;
    std::vector<Bits> found;
    if (nodes[i].kind == NodeKind::Link) {
      if (!search(plan, i + 1, found)) return false;
    } else if (!choice_alternatives(plan, i, found)) {
      return false;
    }
    link_alternatives_[i] = std::move(found);
  }
  return true;
}

// Those of its ports, in their order: what differs between them differs in leaves.
bool Core::choice_alternatives(const Plan& plan, u32 choice, std::vector<Bits>& found) {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  for (u32 child = choice + 1; child < nodes[choice].end; child = nodes[child].end) {
    if (nodes[child].kind == NodeKind::Leaf) {
      if (enabled_row(nodes[child].ref) == kNone) continue;
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
bool Core::enumerate(const Plan& plan, std::vector<Bits>& found) {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  look_at_availability(plan, 0);
  const auto too_many = [&] { return fail_connector(FaultCode::TooManyInteractions, plan.connector); };
  std::vector<std::vector<Bits>> choices(plan.node_count);
  for (u32 i = plan.node_count; i-- > 0;) {
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
      if (product > options_.enumeration_bound) return too_many();
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
  return true;
}

}  // namespace bip::rt
