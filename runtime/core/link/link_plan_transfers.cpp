// Linking: what a rigid plan fires, in order: its ports, and between them the code of its connectors (PlanTransfer).
// All of it takes part each time, so nothing is left to be found when it fires. See tables.hpp. Cost: linear in the
// plans.
#include "bip/assert.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

namespace {

class PlanTransfers {
 public:
  PlanTransfers(Tables& tables, Plan& plan) : tables_(tables), plan_(plan) {}

  void list() {
    BIP_ASSERT(plan_.rigid && !plan_.has_choice && plan_.witnesses.empty(), "the ports of a plan that has choices");
    plan_.first_port = static_cast<u32>(tables_.plan_ports.size());
    plan_.first_transfer = static_cast<u32>(tables_.plan_transfers.size());
    // Parents come before children in a plan: backwards is bottom up.
    for (u32 i = plan_.use_count; plan_.needs_ups && i-- > 0;) add(use(i), &Clause::up);
    std::vector<std::pair<u32, u32>> stack{{0, 0}};  // a use and its next parameter
    while (!stack.empty()) {
      const PlanUse& at = use(stack.back().first);
      const u32 param = stack.back().second++;
      if (param == 0 && plan_.needs_ups) add(at, &Clause::down);
      if (param == tables_.connector_type(at.connector).params.size) {
        stack.pop_back();
        continue;
      }
      const u32 row = tables_.plan_params[at.first_param + param];
      if (row == kNone) continue;
      const PlanNode& node = tables_.plan_nodes[plan_.first_node + row];
      if (node.kind == NodeKind::Link) stack.emplace_back(node.use, 0);
      else tables_.plan_ports.push_back(node.ref);
    }
    plan_.port_count = static_cast<u32>(tables_.plan_ports.size()) - plan_.first_port;
    plan_.end_transfer = static_cast<u32>(tables_.plan_transfers.size());
  }

 private:
  const PlanUse& use(u32 row) const { return tables_.plan_uses[plan_.first_use + row]; }

  // `up` begins with own data of zero.
  void add(const PlanUse& use, u32 Clause::*code) {
    const ConnectorType& type = tables_.connector_type(use.connector);
    PlanTransfer transfer;
    transfer.code = use.clause == kNone ? kNone : type.clauses[use.clause].*code;
    transfer.zeroed = code == &Clause::up ? type.variables.size : 0;
    if (transfer.code == kNone && transfer.zeroed == 0) return;
    const Connector& row = tables_.image->connectors[use.connector];
    transfer.connector = use.connector;
    transfer.first_cell = row.variable(0);
    transfer.binds = row.binds;
    transfer.port_end = static_cast<u32>(tables_.plan_ports.size()) - plan_.first_port;
    tables_.plan_transfers.push_back(transfer);
  }

  Tables& tables_;
  Plan& plan_;
};

}  // namespace

void link_plan_transfers(Tables& tables) {
  for (Plan& plan : tables.plans) {
    if (plan.rigid && !plan.has_choice && plan.witnesses.empty()) PlanTransfers(tables, plan).list();
  }
}

}  // namespace bip::rt
