// See plan_builder.hpp.
#include "runtime/core/link/plan_builder.hpp"

#include <algorithm>
#include <utility>

#include "bip/assert.hpp"

namespace bip::rt {

u32 PlanBuilder::clause_of_all(u32 connector_type) {
  const u32 count = tables_.image->connector_types[connector_type].params.size;
  while (all_params_.size() < count) all_params_.push_back(static_cast<u32>(all_params_.size()));
  return tables_.clause_of(connector_type, {all_params_.data(), count});
}

void PlanBuilder::add(InteractionInfo& info) {
  if (tables_.plans.empty()) {
    plan_of_connector_.assign(tables_.image->connectors.size, 0);
    if (!tables_.inner_rules.groups.empty()) listed_for_ = plan_of_connector_;
  }
  plan_ = {};
  code_ = {};
  links_ = maximal_ = 0;
  plan_.connector = info.row;
  plan_.first_node = static_cast<u32>(tables_.plan_nodes.size());
  plan_.first_use = static_cast<u32>(tables_.plan_uses.size());
  // Members of groups of inner rules get trees of their own, once the connector's is complete: what they offer decides
  // what is hidden.
  if (!tables_.inner_rules.groups.empty()) list_members(info.row);
  add_use(info.row, kNone);
  while (!todo_.empty() || !members_.empty()) {
    if (todo_.empty()) add_member();
    add_node();
  }
  plan_.node_count = static_cast<u32>(tables_.plan_nodes.size()) - plan_.first_node;
  plan_.use_count = static_cast<u32>(tables_.plan_uses.size()) - plan_.first_use;
  plan_.words = (plan_.leaves + 63) / 64;
  finish_nodes();
  finish_uses();
  const bool has_witnesses = !plan_.witnesses.empty();
  plan_.is_listed_at_once = plan_.rigid && plan_.is_tree && !has_witnesses && (maximal_ == 0 || maximal_ == links_);
  plan_.has_ranges = plan_.guarded && !plan_.rigid && !plan_.has_choice && plan_.is_tree && code_.all_have_ranges;
  const bool is_up_seen = tables_.image->ffi != nullptr || plan_.has_choice;
  plan_.needs_ups = has_witnesses || code_.any_down || (is_up_seen && code_.any_up);
  // Alternatives of one parameter are several candidates: they are listed.
  info.searched |= plan_.guarded || plan_.has_choice || has_witnesses;
  info.ref = static_cast<u32>(tables_.plans.size());
  tables_.plans.push_back(std::move(plan_));
}

// Members of the groups that decide about the connector's interactions, or about those of connectors below it, those of
// outer compounds first.
void PlanBuilder::list_members(u32 top) {
  const Image& image = *tables_.image;
  const InnerRules& inner = tables_.inner_rules;
  const u32 stamp = static_cast<u32>(tables_.plans.size()) + 1;
  groups_.clear();
  todo_connectors_.assign(1, top);
  const auto visit = [&](const PortRef& ref) {
    if (ref.connector != kNone) todo_connectors_.push_back(ref.connector);
  };
  while (!todo_connectors_.empty()) {
    const u32 connector = todo_connectors_.back();
    todo_connectors_.pop_back();
    if (std::exchange(listed_for_[connector], stamp) == stamp) continue;
    const u32 group = inner.of_connector(connector);
    if (group != kNone && std::find(groups_.begin(), groups_.end(), group) == groups_.end()) {
      groups_.push_back(group);
      for (const u32 member : inner.groups[group].members) todo_connectors_.push_back(member);
    }
    for (u32 param = 0; param < tables_.connector_type(connector).params.size; ++param) {
      const PortRef ref = tables_.port_ref(connector, param);
      visit(ref);
      if (ref.choice == kNone) continue;
      for (const PortRef& port : image.choices[ref.choice].ports) visit(port);
    }
  }
  const auto key = [&](u32 group) { return std::pair(inner.groups[group].depth, group); };
  std::sort(groups_.begin(), groups_.end(), [&](u32 a, u32 b) { return key(a) < key(b); });
  for (const u32 group : groups_) {
    for (const u32 member : inner.groups[group].members) members_.push_back({group, member});
  }
  std::reverse(members_.begin(), members_.end());
}

void PlanBuilder::add_use(u32 connector, u32 link) {
  const u32 type_row = tables_.image->connectors[connector].type;
  const ConnectorType& type = tables_.image->connector_types[type_row];
  for (const Clause& clause : type.clauses) {
    plan_.guarded |= clause.guard != kNone || clause.may_fault;
    code_.all_have_ranges &= clause.has_ranges;
    code_.any_up |= clause.up != kNone;
    code_.any_down |= clause.down != kNone;
  }
  const u32 stamp = static_cast<u32>(tables_.plans.size()) + 1;
  if (std::exchange(plan_of_connector_[connector], stamp) == stamp) plan_.is_tree = false;
  const u32 use = static_cast<u32>(tables_.plan_uses.size()) - plan_.first_use;
  tables_.plan_uses.push_back(
      {connector, 0, static_cast<u32>(tables_.plan_params.size()), link, clause_of_all(type_row)});
  for (u32 param = 0; param < type.params.size; ++param) tables_.plan_params.push_back(kNone);
  todo_.push_back({use, 0, link, false, nullptr});
}

void PlanBuilder::add_member() {
  const Member member = members_.back();
  members_.pop_back();
  plan_.witnesses.push_back({member.group, member.connector,
                             static_cast<u32>(tables_.plan_uses.size()) - plan_.first_use,
                             static_cast<u32>(tables_.plan_nodes.size()) - plan_.first_node});
  add_use(member.connector, kNone);
}

void PlanBuilder::add_node() {
  const Todo next = todo_.back();
  todo_.pop_back();
  PlanUse& use = tables_.plan_uses[plan_.first_use + next.use];
  const Connector connector = tables_.image->connectors[use.connector];
  const Span<DefineNode>& all = tables_.image->connector_types[connector.type].define;
  const DefineNode& define = all[next.define];
  const u32 row = static_cast<u32>(tables_.plan_nodes.size()) - plan_.first_node;
  PlanNode& node = tables_.plan_nodes.emplace_back();
  node.trigger = next.trigger;
  node.parent = next.parent;
  node.leaf = plan_.leaves;
  node.use = next.use;
  if (next.define == 0 && next.alternative == nullptr) use.root = row;
  if (next.alternative == nullptr && !define.is_leaf) {
    node.kind = NodeKind::Group;
    node.children = define.children.size;
    for (u32 i = define.children.size; i-- > 0;) {
      const u32 child = define.children[i];
      node.has_trigger |= all[child].trigger;
      todo_.push_back({next.use, child, row, all[child].trigger, nullptr});
    }
    plan_.rigid &= !node.has_trigger;
    return;
  }
  if (next.alternative == nullptr) tables_.plan_params[use.first_param + define.param] = row;
  const PortRef ref =
      next.alternative != nullptr ? *next.alternative : tables_.image->port_refs[connector.ports + define.param];
  BIP_ASSERT(next.alternative == nullptr || ref.choice == kNone, "a merged port among the ports of a merged port");
  if (ref.choice != kNone) {
    const Span<PortRef>& ports = tables_.image->choices[ref.choice].ports;
    node.kind = NodeKind::Choice;
    node.maximal_only = true;
    node.children = ports.size;
    node.ref = ref.choice;
    use.has_choice = plan_.has_choice = true;
    plan_.rigid = false;
    ++maximal_;
    for (u32 i = ports.size; i-- > 0;) todo_.push_back({next.use, next.define, row, false, &ports[i]});
  } else if (ref.atom != kNone) {
    node.kind = NodeKind::Leaf;
    node.ref = tables_.instance(ref.atom, ref.port);
    ++plan_.leaves;
  } else {
    node.kind = NodeKind::Link;
    node.maximal_only = ref.maximal_only;
    node.children = 1;
    node.ref = ref.connector;
    node.use = static_cast<u32>(tables_.plan_uses.size()) - plan_.first_use;
    ++links_;
    maximal_ += ref.maximal_only ? 1 : 0;
    add_use(ref.connector, row);
  }
}

// Where the subtrees end.
void PlanBuilder::finish_nodes() {
  PlanNode* nodes = tables_.plan_nodes.data() + plan_.first_node;
  for (u32 i = plan_.node_count; i-- > 0;) {
    nodes[i].end = std::max(nodes[i].end, i + 1);
    if (nodes[i].parent == kNone) continue;
    BIP_ASSERT(nodes[i].parent < i, "node {} comes before its parent", i);
    PlanNode& parent = nodes[nodes[i].parent];
    parent.end = std::max(parent.end, nodes[i].end);
  }
  // Trees of witnesses come behind the connector's own.
  BIP_ASSERT(plan_.use_count != 0 &&
                 nodes[0].end == (plan_.witnesses.empty() ? plan_.node_count : plan_.witnesses.front().root),
             "a plan of {} nodes, its root ends at {}", plan_.node_count, nodes[0].end);
}

void PlanBuilder::finish_uses() {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan_.first_node;
  for (u32 i = 0; i < plan_.use_count; ++i) {
    PlanUse& use = tables_.plan_uses[plan_.first_use + i];
    const u32 end = nodes[use.root].end;
    use.first_leaf = nodes[use.root].leaf;
    use.end_leaf = end == plan_.node_count ? plan_.leaves : nodes[end].leaf;
    BIP_ASSERT(use.first_leaf <= use.end_leaf && use.end_leaf <= plan_.leaves, "leaves {} to {} of {}", use.first_leaf,
               use.end_leaf, plan_.leaves);
  }
}

}  // namespace bip::rt
