// Linking: for plans that choose by triggers alone, how their ports are listed (PlanChoice). See tables.hpp.
//
// The largest available configuration of such a plan: from the root down, of a group with triggers what is available,
// of any other group all. In the order of firing, which is that of parameters, depth first, this is a list of ports
// under conditions; the availability network knows each of them. Cost: linear in the plans.
#include "bip/assert.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

namespace {

using Kind = PlanChoice::Kind;

class PlanChoices {
 public:
  PlanChoices(Tables& tables, const std::vector<u32>& first_group, Plan& plan)
      : tables_(tables), first_group_(first_group), plan_(plan) {}

  void list() {
    plan_.first_choice = static_cast<u32>(tables_.plan_choices.size());
    stack_.push_back({0, 0, 0});
    while (!stack_.empty()) {
      Entry& entry = stack_.back();
      const PlanUse& use = tables_.plan_uses[plan_.first_use + entry.use];
      if (entry.next == tables_.connector_type(use.connector).params.size) {
        close(entry.open);
        stack_.pop_back();
        continue;
      }
      const u32 row = tables_.plan_params[use.first_param + entry.next++];
      if (row == kNone) continue;
      open_groups(use, entry.open, row);
      add(row);
    }
    close(0);
    plan_.end_choice = static_cast<u32>(tables_.plan_choices.size());
  }

 private:
  struct Entry {
    u32 use, next;     // its next parameter
    std::size_t open;  // so many groups were open when it began
  };
  struct Open {
    u32 node, choice;  // row in the plan; row of plan_choices
  };

  const PlanNode& node(u32 row) const { return tables_.plan_nodes[plan_.first_node + row]; }
  bool is_optional(u32 row) const { return node(row).parent != kNone && node(node(row).parent).has_trigger; }

  // Closes groups until so many are open.
  void close(std::size_t open) {
    for (; open_.size() > open; open_.pop_back())
      tables_.plan_choices[open_.back().choice].end = static_cast<u32>(tables_.plan_choices.size());
  }
  // Which of a use's groups the node of a parameter is in, of those that need not take part: closes and opens others.
  void open_groups(const PlanUse& use, std::size_t bottom, u32 row) {
    std::vector<u32> groups;  // innermost first
    for (u32 at = row == use.root ? row : node(row).parent; at != use.root; at = node(at).parent) {
      if (is_optional(at)) groups.push_back(at);
    }
    std::size_t same = 0;
    while (same < groups.size() && bottom + same < open_.size() &&
           open_[bottom + same].node == groups[groups.size() - 1 - same])
      ++same;
    close(bottom + same);
    for (; same < groups.size(); ++same) {
      const u32 group = groups[groups.size() - 1 - same];
      open(group, network_node(use, group));
    }
  }
  void open(u32 row, u32 network_node) {
    open_.push_back({row, static_cast<u32>(tables_.plan_choices.size())});
    tables_.plan_choices.push_back({Kind::Group, network_node, 0});
  }
  void add(u32 row) {
    if (node(row).kind == NodeKind::Leaf) {
      tables_.plan_choices.push_back({is_optional(row) ? Kind::PortIfEnabled : Kind::Port, node(row).ref, 0});
      return;
    }
    BIP_ASSERT(node(row).kind == NodeKind::Link, "a merged port in a plan without choices");
    const u32 use = node(row).use;
    if (is_optional(row)) open(row, first_group_[tables_.plan_uses[plan_.first_use + use].connector]);
    stack_.push_back({use, 0, open_.size()});
  }
  // The groups of a use are in the plan in the order of its `define`: the k-th is the k-th there.
  u32 network_node(const PlanUse& use, u32 row) const {
    u32 groups = 0;
    for (u32 at = use.root; at < row; ++at) groups += node(at).kind == NodeKind::Group && is_of(use, at) ? 1 : 0;
    const bool is_interaction = tables_.interaction_of(use.connector).is_valid();
    return first_group_[use.connector] + groups - (is_interaction ? 1 : 0);
  }
  bool is_of(const PlanUse& use, u32 row) const { return &tables_.plan_uses[plan_.first_use + node(row).use] == &use; }

  Tables& tables_;
  const std::vector<u32>& first_group_;
  Plan& plan_;
  std::vector<Entry> stack_;
  std::vector<Open> open_;
};

}  // namespace

void link_plan_choices(Tables& tables, const std::vector<u32>& first_group) {
  for (Plan& plan : tables.plans) {
    if (plan.rigid || plan.guarded || plan.has_choice || plan.needs_ups || !plan.witnesses.empty()) continue;
    PlanChoices(tables, first_group, plan).list();
  }
}

}  // namespace bip::rt
