// See firing.hpp.
#include "runtime/core/fire/firing.hpp"

#include <algorithm>
#include <bit>

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"

namespace bip::rt {

bool Firing::fire(const Candidate& candidate) {
  if (!core_.partial.is_beginning()) {
    const u32* program = core_.programs.program_of(candidate.interaction);
    if (*program != kNone) return core_.programs.run(program, candidate.interaction);
  }
  return fire_parts(candidate);
}

bool Firing::fire(const Candidate& candidate, Span<u32> ports) {
  const InteractionInfo info = core_.tables.interactions[candidate.interaction];
  const bool has_code = info.kind != InteractionKind::Planned || core_.tables.plans[info.plan()].needs_ups;
  if (has_code || core_.partial.is_on()) return fire(candidate);
  core_.history.remember(candidate.interaction);
  return core_.atom_steps.fire_ports(ports) && core_.settle();
}

bool Firing::fire_parts(const Candidate& candidate) {
  BIP_ASSERT(core_.enabled.weight(candidate.interaction) != 0, "interaction {} has no candidate",
             candidate.interaction);
  const InteractionInfo info = core_.tables.interactions[candidate.interaction];
  BIP_ASSERT(core_.ports.is_available(candidate.interaction) || core_.partial.is_on(),
             "interaction {} is not available", candidate.interaction);
  core_.history.remember(candidate.interaction);
  bool done = false;
  switch (info.kind) {
    case InteractionKind::Flat: done = fire_flat(info); break;
    case InteractionKind::Star: done = fire_star(info); break;
    case InteractionKind::Planned: {
      const Plan& plan = core_.tables.plans[info.plan()];
      done = plan.port_count != 0 ? fire_rigid(plan) : fire_planned(candidate, info);
      break;
    }
    case InteractionKind::Port: done = core_.atom_steps.fire_port(info.row); break;
  }
  return done && (!core_.partial.is_on() ? core_.settle() : core_.partial.settle());
}

void Firing::zero_frame(u32 connector) {
  // A row of connectors is found in O(log rows): once.
  const Connector& row = core_.tables.image->connectors[connector];
  const Span<Var>& variables = core_.tables.image->connector_types[row.type].variables;
  Cell* frame = core_.memory.cells.from(row.variable(0));
  for (u32 i = 0; i < variables.size; ++i) frame[i] = Cell{0};
  if (!core_.memory.ffi_data.empty()) core_.memory.ffi_data.reset(variables, core_.memory.cells.all(), row.first_cell);
}

bool Firing::run_code(Code code, u32 connector) {
  BIP_ASSERT(code.fn == nullptr || core_.tables.image->connectors[connector].bind_count == 0 ||
                 core_.memory.binds.rows != nullptr,
             "connector {} reads variables that are not bound", connector);
  if (code.fn == nullptr) return true;
  const Connector& row = core_.tables.image->connectors[connector];
  const std::int32_t status = code.fn(code.context, core_.memory.cells.from(row.variable(0)), core_.memory.cells.all(),
                                      core_.memory.binds.rows + row.binds);
  return status < 2 || core_.faults.fail_code(status, kNone, connector, nullptr);
}

// The transfer of a connector of atom ports: own data start at zero.
bool Firing::run_transfer(const InteractionInfo& info, u32 row) {
  const Clause& clause = core_.tables.connector_type(info.row).clauses[row];
  zero_frame(info.row);
  return run_code(core_.tables.code(clause.up), info.row) && run_code(core_.tables.code(clause.down), info.row);
}

bool Firing::fire_flat(const InteractionInfo& info) {
  if (info.clause() != kNone && !run_transfer(info, info.clause())) return false;
  BIP_ASSERT(info.first + info.count <= core_.tables.flat_ports.size(), "ports {} to {}", info.first,
             info.first + info.count);
  return core_.atom_steps.fire_ports(core_.tables.fixed_ports(info));
}

// Its code and its ports in turn.
bool Firing::fire_rigid(const Plan& plan) {
  const u32* const ports = core_.tables.plan_ports.data() + plan.first_port;
  u32 fired = 0;
  for (u32 row = plan.first_transfer; row < plan.end_transfer; ++row) {
    const PlanTransfer& transfer = core_.tables.plan_transfers[row];
    if (transfer.port_end != fired && !core_.atom_steps.fire_ports({ports + fired, transfer.port_end - fired}))
      return false;
    fired = transfer.port_end;
    Cell* const own = core_.memory.cells.from(transfer.first_cell);
    for (u32 i = 0; i < transfer.zeroed; ++i) own[i] = Cell{0};
    if (transfer.zeroed != 0 && !core_.memory.ffi_data.empty()) {
      core_.memory.ffi_data.reset(core_.tables.connector_type(transfer.connector).variables, core_.memory.cells.all(),
                                  transfer.first_cell.value);
    }
    const Code code = core_.tables.code(transfer.code);
    if (code.fn == nullptr) continue;
    const std::int32_t status =
        code.fn(code.context, own, core_.memory.cells.all(), core_.memory.binds.rows + transfer.binds);
    if (status >= 2) return core_.faults.fail_code(status, kNone, transfer.connector, nullptr);
  }
  return core_.atom_steps.fire_ports({ports + fired, plan.port_count - fired});
}

// All ports that are ready take part; that a port fires changes no other atom's readiness, so one pass finds and fires.
bool Firing::fire_star(const InteractionInfo& info) {
  const u32* ports = core_.tables.flat_ports.data() + info.first;
  const u32 type_row = core_.tables.image->connectors[info.row].type;
  BIP_ASSERT(info.clause() == kNone, "a broadcast with one clause");
  if (core_.tables.clause_order[type_row].size != 0) {
    params_.clear();
    for (u32 i = 0; i < info.count; ++i) {
      if (core_.ports.enabled_row(ports[i]) != kNone) params_.push_back(i);
    }
    const u32 row = core_.tables.clause_of(type_row, {params_.data(), static_cast<u32>(params_.size())});
    if (row != kNone && !run_transfer(info, row)) return false;
  }
  // 64 at a time: which are ready cannot be predicted, so that is computed without branches; only set bits are visited.
  for (u32 first = 0; first < info.count; first += 64) {
    const u32 count = std::min(info.count - first, 64u);
    u64 ready = 0;
    for (u32 i = 0; i < count; ++i) {
      const PortState& port = core_.ports.port(ports[first + i]);
      const bool is_there =
          (port.place == kNone) | (core_.memory.places[core_.tables.port_atom[ports[first + i]]] == port.place);
      ready |= static_cast<u64>(is_there & (port.transition != kNone)) << i;
    }
    for (; ready != 0; ready &= ready - 1) {
      if (!core_.atom_steps.fire_port(ports[first + static_cast<u32>(std::countr_zero(ready))])) return false;
    }
  }
  return true;
}

bool Firing::fire_planned(const Candidate& candidate, const InteractionInfo& info) {
  const Plan& plan = core_.tables.plans[info.plan()];
  BIP_ASSERT(plan.port_count == 0, "a plan that has no choice");
  if (!plan.needs_ups) return core_.atom_steps.fire_ports(planned_ports(candidate, info));
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  core_.search.choose(candidate, plan);
  // Faults of `up`s are found when candidates are listed.
  if (!core_.search.run_ups(plan)) return false;
  // Depth first over (use, next parameter); a stack, for the hierarchy may be deep.
  use_stack_.clear();
  use_stack_.emplace_back(0, 0);
  while (!use_stack_.empty()) {
    const u32 at = use_stack_.back().first;
    BIP_ASSERT(at < plan.use_count && use_stack_.size() <= plan.use_count, "{} uses within each other",
               use_stack_.size());
    const PlanUse& use = core_.tables.plan_uses[plan.first_use + at];
    const ConnectorType& type = core_.tables.connector_type(use.connector);
    u32 param = use_stack_.back().second;
    if (param == 0 && core_.search.clause_of_use(at) != kNone) {
      if (!run_code(core_.tables.code(type.clauses[core_.search.clause_of_use(at)].down), use.connector)) return false;
    }
    // Up to the next use below this one.
    u32 below = kNone;
    while (param < type.params.size && below == kNone) {
      u32 node = core_.tables.plan_params[use.first_param + param++];
      if (node == kNone || !core_.search.is_chosen(node)) continue;
      if (nodes[node].kind == NodeKind::Choice) node = core_.search.chosen_alternative(plan, node);
      if (nodes[node].kind == NodeKind::Link) below = nodes[node].use;
      else if (!core_.atom_steps.fire_port(nodes[node].ref)) return false;
    }
    use_stack_.back().second = param;
    if (below != kNone) use_stack_.emplace_back(below, 0);
    else use_stack_.pop_back();
  }
  return true;
}

// In the order of firing.
template <class Visit>
void Firing::visit_chosen(const Plan& plan, const Visit& visit) {
  const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
  use_stack_.clear();
  use_stack_.emplace_back(0, 0);
  while (!use_stack_.empty()) {
    const PlanUse& use = core_.tables.plan_uses[plan.first_use + use_stack_.back().first];
    const u32 param = use_stack_.back().second++;
    if (param == core_.tables.connector_type(use.connector).params.size) {
      use_stack_.pop_back();
      continue;
    }
    u32 node = core_.tables.plan_params[use.first_param + param];
    if (node == kNone || !core_.search.is_chosen(node)) continue;
    if (nodes[node].kind == NodeKind::Choice) node = core_.search.chosen_alternative(plan, node);
    if (nodes[node].kind == NodeKind::Link) use_stack_.emplace_back(nodes[node].use, 0);
    else visit(param, nodes[node].ref);
  }
}

void Firing::participants(const Candidate& candidate, std::vector<Participant>& out) {
  out.clear();
  const InteractionInfo info = core_.tables.interactions[candidate.interaction];
  const auto add = [&](u32 param, u32 instance) {
    const u32 atom = core_.tables.port_atom[instance];
    out.push_back({param, atom, instance - core_.tables.port_base(atom), kNone});
  };
  if (info.kind == InteractionKind::Port) {
    add(0, info.row);
    return;
  }
  if (info.kind != InteractionKind::Planned) {
    for (u32 i = 0; i < info.count; ++i) {
      const u32 instance = core_.tables.flat_ports[info.first + i];
      if (core_.ports.enabled_row(instance) != kNone) add(i, instance);
    }
    return;
  }
  const Plan& plan = core_.tables.plans[info.plan()];
  core_.search.choose(candidate, plan);
  visit_chosen(plan, add);
}

Span<u32> Firing::ports(const Candidate& candidate) {
  const InteractionInfo info = core_.tables.interactions[candidate.interaction];
  if (const Span<u32> fixed = core_.tables.fixed_ports(info); fixed.size != 0) return fixed;
  ports_.clear();
  if (info.kind == InteractionKind::Port) {
    ports_.push_back(info.row);
  } else if (info.kind != InteractionKind::Planned) {
    for (u32 i = info.first; i < info.first + info.count; ++i) {
      if (core_.ports.enabled_row(core_.tables.flat_ports[i]) != kNone) ports_.push_back(core_.tables.flat_ports[i]);
    }
  } else {
    return planned_ports(candidate, info);
  }
  return {ports_.data(), static_cast<u32>(ports_.size())};
}

// What is available takes part.
Span<u32> Firing::list_choices(const Plan& plan) {
  const PlanChoice* const choices = core_.tables.plan_choices.data();
  // Room for all of them.
  if (ports_.size() < plan.end_choice - plan.first_choice) ports_.resize(plan.end_choice - plan.first_choice);
  u32* const out = ports_.data();
  u32 count = 0;
  for (u32 row = plan.first_choice; row < plan.end_choice;) {
    const PlanChoice& choice = choices[row++];
    if (choice.kind == PlanChoice::Kind::Group) {
      if (core_.ports.values()[choice.ref] < 0) row = choice.end;
    } else if (choice.kind == PlanChoice::Kind::Port || core_.ports.enabled_row(choice.ref) != kNone) {
      out[count++] = choice.ref;
    }
  }
  return {out, count};
}

Span<u32> Firing::planned_ports(const Candidate& candidate, const InteractionInfo& info) {
  const Plan& plan = core_.tables.plans[info.plan()];
  if (plan.end_choice != plan.first_choice && !info.searched) {
    return list_choices(plan);
  }
  if (choices_.empty()) choices_.resize(core_.tables.plans.size());
  ListedChoices& known = choices_[info.plan()];
  const Span<u64> key = core_.search.choice_key(candidate, plan);
  for (ListedChoice& choice : known.choices) {
    if (std::equal(key.begin(), key.end(), choice.key.begin(), choice.key.end()))
      return {choice.ports.data(), static_cast<u32>(choice.ports.size())};
  }
  if (known.choices.size() < kListedChoices) known.choices.emplace_back();
  ListedChoice& choice = known.choices[known.next];
  known.next = (known.next + 1) % kListedChoices;
  choice.key.assign(key.begin(), key.end());
  choice.ports.clear();
  core_.search.choose(candidate, plan);
  visit_chosen(plan, [&](u32, u32 instance) { choice.ports.push_back(instance); });
  return {choice.ports.data(), static_cast<u32>(choice.ports.size())};
}

void Firing::direct_participants(const Candidate& candidate, std::vector<Participant>& out) {
  const InteractionInfo info = core_.tables.interactions[candidate.interaction];
  if (info.kind != InteractionKind::Planned) {
    participants(candidate, out);
    return;
  }
  out.clear();
  const Plan& plan = core_.tables.plans[info.plan()];
  core_.search.choose(candidate, plan);
  // The same `up`s ran when the candidate was listed or will when it fires; a fault shows there.
  const Fault before = core_.fault;
  core_.memory.binds.make(*core_.tables.image);
  (void)core_.search.run_ups(plan);
  core_.fault = before;
  const PlanUse& use = core_.tables.plan_uses[plan.first_use];
  const ConnectorType& type = core_.tables.connector_type(use.connector);
  for (u32 param = 0; param < type.params.size; ++param) {
    u32 node = core_.tables.plan_params[use.first_param + param];
    const PlanNode* nodes = core_.tables.plan_nodes.data() + plan.first_node;
    if (node == kNone || !core_.search.is_chosen(node)) continue;
    if (nodes[node].kind == NodeKind::Choice) node = core_.search.chosen_alternative(plan, node);
    if (nodes[node].kind == NodeKind::Link) {
      out.push_back({param, kNone, kNone, nodes[node].ref});
    } else {
      const u32 atom = core_.tables.port_atom[nodes[node].ref];
      out.push_back({param, atom, nodes[node].ref - core_.tables.port_base(atom), kNone});
    }
  }
}

}  // namespace bip::rt
