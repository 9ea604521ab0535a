// Firing: `up` again for the chosen configuration (frames may be stale), then from the top connector `down` and the
// ports in parameter order, depth first; an atom's port takes its recorded transition, its guard is not evaluated
// again.
//
// Cost: what takes part. A flat rendezvous is a loop over port instances.
#include <algorithm>
#include <bit>

#include "runtime/core/core.hpp"

namespace bip::rt {

bool Core::fire(const Candidate& candidate) {
  if (partial_ == nullptr) {
    if (rows_.empty()) build_programs();
    const u32* program = rows_.data() + std::size_t{candidate.interaction} * row_words_;
    if (*program != kNone) return run_program(program, candidate.interaction);
  }
  return fire_parts(candidate);
}

bool Core::fire_parts(const Candidate& candidate) {
  const InteractionInfo info = tables_.interactions[candidate.interaction];
  remember(candidate.interaction);
  bool done = false;
  switch (info.kind) {
    case InteractionKind::Flat: done = fire_flat(info); break;
    case InteractionKind::Star: done = fire_star(info); break;
    case InteractionKind::Planned: done = fire_planned(candidate, info); break;
    case InteractionKind::Port: done = fire_port(info.row); break;
  }
  return done && (partial_ == nullptr ? settle() : settle_partial());
}

void Core::zero_frame(u32 connector) {
  const u32 size = tables_.connector_type(connector).variables.size;
  Cell* frame = all_.data() + tables_.image->connectors[connector].first_cell;
  for (u32 i = 0; i < size; ++i) frame[i] = Cell{0};
  if (!ffi_data_.empty())
    ffi_data_.reset(tables_.connector_type(connector).variables, all_.data(),
                    tables_.image->connectors[connector].first_cell);
}

bool Core::run_code(Code code, u32 connector) {
  if (code.fn == nullptr) return true;
  const Connector& row = tables_.image->connectors[connector];
  const std::int32_t status = code.fn(code.context, all_.data() + row.first_cell, all_.data(), binds_.rows + row.binds);
  return status < 2 || fail_code(status, kNone, connector, nullptr);
}

u32 Core::chosen_alternative(const Plan& plan, u32 choice) const {
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  u32 child = choice + 1;
  while (chosen_[child] == 0) child = nodes[child].end;
  return child;
}

// Lets the parameters that are bound to merged ports name the variables of the chosen alternatives.
void Core::bind_choices(const Plan& plan, const PlanUse& use) {
  const Image& image = *tables_.image;
  const ConnectorType& type = tables_.connector_type(use.connector);
  for (u32 param = 0; param < type.params.size; ++param) {
    const u32 node = tables_.plan_params[use.first_param + param];
    const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
    if (node == kNone || nodes[node].kind != NodeKind::Choice || chosen_[node] == 0) continue;
    const PlanNode& chosen = nodes[chosen_alternative(plan, node)];
    u32* row = binds_.own.data() + image.connectors[use.connector].binds + type.params[param].first_bind;
    if (chosen.kind == NodeKind::Leaf) {
      const u32 atom = tables_.port_atom[chosen.ref];
      const Port& port = tables_.atom_type(atom).ports[chosen.ref - tables_.port_base(atom)];
      for (u32 interaction : port.variables) *row++ = atoms_[atom].first_cell + interaction;
    } else {
      for (u32 interaction : tables_.connector_type(chosen.ref).export_variables)
        *row++ = image.connectors[chosen.ref].first_cell + interaction;
    }
  }
}

// The transfer of a connector of atom ports: own data start at zero.
bool Core::run_transfer(const InteractionInfo& info, u32 row) {
  const Clause& clause = tables_.connector_type(info.row).clauses[row];
  zero_frame(info.row);
  return run_code(tables_.code(clause.up), info.row) && run_code(tables_.code(clause.down), info.row);
}

bool Core::fire_flat(const InteractionInfo& info) {
  if (info.clause() != kNone && !run_transfer(info, info.clause())) return false;
  const u32* ports = tables_.flat_ports.data() + info.first;
  for (u32 i = 0; i < info.count; ++i) {
    if (!fire_port(ports[i])) return false;
  }
  return true;
}

// Whoever is ready takes part; that a port fires changes no other atom's readiness, so one pass finds and fires.
bool Core::fire_star(const InteractionInfo& info) {
  const u32* ports = tables_.flat_ports.data() + info.first;
  const u32 type_row = tables_.image->connectors[info.row].type;
  if (!tables_.clause_order[type_row].empty()) {
    params_.clear();
    for (u32 i = 0; i < info.count; ++i) {
      if (enabled_row(ports[i]) != kNone) params_.push_back(i);
    }
    const u32 row = tables_.clause_of(type_row, {params_.data(), static_cast<u32>(params_.size())});
    if (row != kNone && !run_transfer(info, row)) return false;
  }
  // 64 at a time: who is ready nobody can predict, so it is asked without branches, and only the answers are walked.
  for (u32 first = 0; first < info.count; first += 64) {
    const u32 count = std::min(info.count - first, 64u);
    u64 ready = 0;
    for (u32 i = 0; i < count; ++i) {
      const PortState& port = ports_[ports[first + i]];
      const bool is_there = (port.place == kNone) | (places_[tables_.port_atom[ports[first + i]]] == port.place);
      ready |= static_cast<u64>(is_there & (port.transition != kNone)) << i;
    }
    for (; ready != 0; ready &= ready - 1) {
      if (!fire_port(ports[first + static_cast<u32>(std::countr_zero(ready))])) return false;
    }
  }
  return true;
}

void Core::choose(const Candidate& candidate, const Plan& plan) {
  if (listing_of(candidate.interaction) != kNone) {
    choose_bits(
        plan, listings_[listing_of(candidate.interaction)].configs.data() + std::size_t{candidate.config} * plan.words);
    return;
  }
  if (plan.rigid) {
    std::fill(chosen_.begin(), chosen_.begin() + plan.node_count, std::uint8_t{1});
    return;
  }
  look_at_availability(plan, 0);
  choose_largest(plan, 0);
}

bool Core::run_ups(const Plan& plan) {
  // Parents come before children in a plan: backwards is bottom up.
  for (u32 i = plan.use_count; i-- > 0;) {
    const PlanUse& use = tables_.plan_uses[plan.first_use + i];
    if (chosen_[use.root] == 0) continue;
    zero_frame(use.connector);
    if (use.has_choice) bind_choices(plan, use);
    const u32 row = chosen_clause(plan, i);
    use_clause_[i] = row;
    if (row == kNone) continue;
    if (!run_code(tables_.code(tables_.connector_type(use.connector).clauses[row].up), use.connector)) return false;
  }
  return true;
}

bool Core::fire_planned(const Candidate& candidate, const InteractionInfo& info) {
  const Plan& plan = tables_.plans[info.plan()];
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  choose(candidate, plan);
  if (!run_ups(plan)) return false;
  // Depth first over (use, next parameter); a stack, for the hierarchy may be deep.
  use_stack_.clear();
  use_stack_.emplace_back(0, 0);
  while (!use_stack_.empty()) {
    const u32 at = use_stack_.back().first;
    const u32 param = use_stack_.back().second++;
    const PlanUse& use = tables_.plan_uses[plan.first_use + at];
    const ConnectorType& type = tables_.connector_type(use.connector);
    if (param == 0 && use_clause_[at] != kNone) {
      if (!run_code(tables_.code(type.clauses[use_clause_[at]].down), use.connector)) return false;
    }
    if (param == type.params.size) {
      use_stack_.pop_back();
      continue;
    }
    u32 node = tables_.plan_params[use.first_param + param];
    if (node == kNone || chosen_[node] == 0) continue;
    if (nodes[node].kind == NodeKind::Choice) node = chosen_alternative(plan, node);
    if (nodes[node].kind == NodeKind::Link) {
      use_stack_.emplace_back(nodes[node].use, 0);
    } else if (!fire_port(nodes[node].ref)) {
      return false;
    }
  }
  return true;
}

void Core::participants(const Candidate& candidate, std::vector<Participant>& out) {
  out.clear();
  const InteractionInfo info = tables_.interactions[candidate.interaction];
  const auto add = [&](u32 param, u32 instance) {
    const u32 atom = tables_.port_atom[instance];
    out.push_back({param, atom, instance - tables_.port_base(atom), kNone});
  };
  if (info.kind == InteractionKind::Port) {
    add(0, info.row);
    return;
  }
  if (info.kind != InteractionKind::Planned) {
    for (u32 i = 0; i < info.count; ++i) {
      const u32 instance = tables_.flat_ports[info.first + i];
      if (enabled_row(instance) != kNone) add(i, instance);
    }
    return;
  }
  const Plan& plan = tables_.plans[info.plan()];
  const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
  choose(candidate, plan);
  use_stack_.clear();
  use_stack_.emplace_back(0, 0);
  while (!use_stack_.empty()) {
    const PlanUse& use = tables_.plan_uses[plan.first_use + use_stack_.back().first];
    const u32 param = use_stack_.back().second++;
    if (param == tables_.connector_type(use.connector).params.size) {
      use_stack_.pop_back();
      continue;
    }
    u32 node = tables_.plan_params[use.first_param + param];
    if (node == kNone || chosen_[node] == 0) continue;
    if (nodes[node].kind == NodeKind::Choice) node = chosen_alternative(plan, node);
    if (nodes[node].kind == NodeKind::Link) use_stack_.emplace_back(nodes[node].use, 0);
    else add(param, nodes[node].ref);
  }
}

void Core::direct_participants(const Candidate& candidate, std::vector<Participant>& out) {
  const InteractionInfo info = tables_.interactions[candidate.interaction];
  if (info.kind != InteractionKind::Planned) {
    participants(candidate, out);
    return;
  }
  out.clear();
  const Plan& plan = tables_.plans[info.plan()];
  choose(candidate, plan);
  // The same `up`s ran when the candidate was listed or will when it fires; a fault shows there.
  const Fault before = fault_;
  binds_.make(*tables_.image);
  (void)run_ups(plan);
  fault_ = before;
  const PlanUse& use = tables_.plan_uses[plan.first_use];
  const ConnectorType& type = tables_.connector_type(use.connector);
  for (u32 param = 0; param < type.params.size; ++param) {
    u32 node = tables_.plan_params[use.first_param + param];
    const PlanNode* nodes = tables_.plan_nodes.data() + plan.first_node;
    if (node == kNone || chosen_[node] == 0) continue;
    if (nodes[node].kind == NodeKind::Choice) node = chosen_alternative(plan, node);
    if (nodes[node].kind == NodeKind::Link) {
      out.push_back({param, kNone, kNone, nodes[node].ref});
    } else {
      const u32 atom = tables_.port_atom[nodes[node].ref];
      out.push_back({param, atom, nodes[node].ref - tables_.port_base(atom), kNone});
    }
  }
}

}  // namespace bip::rt
