// Computes the interactions that a step may enable or disable: those that count a port that flips, those with a guard
// over data of atoms that move, and those that are hidden by one of these.
#include <algorithm>

#include "compiler/steps/deriver.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::steps {

using rt::InteractionKind;

namespace {

constexpr std::size_t kMaxHiders = 8;

}  // namespace

// Rules that always hold between whole rendezvous without guards: then an interaction is hidden iff one of a fixed set
// of others is available, at the end of a chain of rules or directly.
bool Deriver::link_priorities() {
  std::vector<u32> all;
  enum class Side : std::uint8_t { Low, High };
  const auto matches = [&](u32 rule, rt::InteractionId interaction, Side side) {
    const u32 connector = tables_.connector_of(interaction);
    all.clear();
    for (u32 k = 0; k < tables_.connector_type(connector).params.size; ++k) all.push_back(k);
    const rt::Priority& row = image_.priorities[rule];
    return side == Side::High ? rt::matches_high(tables_, row, connector, all)
                              : rt::matches_low(tables_, row, connector, all);
  };
  std::vector<std::vector<rt::InteractionId>> highs(rules_.count);
  for (const rt::HighEdge& edge : rules_.high_edges) {
    const rt::InteractionInfo info = tables_.interactions[edge.interaction];
    if (info.kind != InteractionKind::Flat || info.searched) return false;
    if (matches(edge.rule, edge.interaction, Side::High)) highs[edge.rule].push_back(edge.interaction);
  }
  std::vector<u32> reached;
  for (u32 rule = 0; rule < rules_.count; ++rule) {
    const rt::Priority& row = image_.priorities[rule];
    if (row.guard != kNone || row.low.any_connector || row.high.any_connector ||
        rules_.cyclic[rules_.component[rule]] != 0)
      return false;
    reached.assign(1, rule);
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const u32 next : rules_.next[reached[i]]) {
        if (std::find(reached.begin(), reached.end(), next) == reached.end()) reached.push_back(next);
      }
      if (reached.size() > kMaxHiders) return false;
    }
    for (const rt::InteractionId low : rules_.interactions_of_low[rule]) {
      if (tables_.interactions[low].kind != InteractionKind::Flat) return false;
      if (!matches(rule, low, Side::Low)) continue;
      std::vector<rt::InteractionId>& hiders = hiders_[low];
      for (const u32 other : reached) hiders.insert(hiders.end(), highs[other].begin(), highs[other].end());
      std::sort(hiders.begin(), hiders.end());
      hiders.erase(std::unique(hiders.begin(), hiders.end()), hiders.end());
      if (hiders.size() > kMaxHiders) return false;
    }
  }
  for (const auto& [low, hiders] : hiders_) {
    for (const rt::InteractionId high : hiders) hidden_[high].push_back(low);
  }
  return true;
}

bool Deriver::add_effects(rt::InteractionId fired, Instance& out) {
  effects_.clear();
  touched_.clear();
  for (const u32 port : ports_) {
    const u32 atom = tables_.port_atom[port];
    if (tables_.atom_rules[atom].size != 0) return false;
    for (const rt::InteractionId interaction : tables_.atom_watch[atom]) touched_.push_back(interaction);
    const rt::LinkedTransition& transition = tables_.transitions[transition_of(port)];
    for (u32 d = 0; d < transition.delta_count; ++d) {
      const rt::PortDelta& delta = tables_.deltas[transition.delta_first + d];
      const u32 moved = tables_.port_base(atom) + delta.port;
      if (tables_.port_watch[moved].size != 0) return false;
      for (const u32 node : tables_.port_out[moved]) {
        if (!tables_.is_interaction(node)) return false;
        effects_.push_back({rt::Tables::interaction_at(node), delta.transition != kNone ? 1 : -1});
      }
    }
  }
  const auto tidy = [&] {
    std::sort(effects_.begin(), effects_.end(),
              [](const Effect& a, const Effect& b) { return a.interaction < b.interaction; });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < effects_.size();) {
      Effect sum = effects_[i];
      for (++i; i < effects_.size() && effects_[i].interaction == sum.interaction; ++i) sum.delta += effects_[i].delta;
      effects_[kept++] = sum;
    }
    BIP_ASSERT(std::is_sorted(effects_.begin(), effects_.begin() + static_cast<std::ptrdiff_t>(kept),
                              [](const Effect& a, const Effect& b) { return a.interaction < b.interaction; }),
               "{} effects are not in the order of interactions", kept);
    effects_.resize(kept);
  };
  tidy();
  std::erase_if(effects_, [](const Effect& e) { return e.delta == 0; });
  for (std::size_t i = effects_.size(); i-- > 0 && !hidden_.empty();) {
    const auto found = hidden_.find(effects_[i].interaction);
    if (found != hidden_.end()) touched_.insert(touched_.end(), found->second.begin(), found->second.end());
  }
  for (const rt::InteractionId interaction : touched_) effects_.push_back({interaction, 0});
  tidy();
  return std::all_of(effects_.begin(), effects_.end(),
                     [&](const Effect& effect) { return add_interaction(effect, fired, out); });
}

bool Deriver::add_interaction(Effect effect, rt::InteractionId fired, Instance& out) {
  const rt::InteractionInfo info = tables_.interactions[effect.interaction];
  // Its value is never above 0: a rendezvous counts what it lacks, a broadcast its only trigger.
  const bool exact = info.kind == InteractionKind::Flat || info.kind == InteractionKind::Port ||
                     (info.kind == InteractionKind::Star && trigger_count(effect.interaction, info) == 1);
  StepOp& op = out.add(StepOpKind::Interaction);
  op.delta = effect.delta;
  out.ref(effect.interaction);
  if (info.searched) {
    if (info.kind != InteractionKind::Flat || info.clause() == kNone) return false;
    const rt::Connector connector = image_.connectors[info.row];
    const rt::ConnectorType& type = tables_.connector_type(info.row);
    const rt::Clause& clause = type.clauses[info.clause()];
    if (clause.guard == kNone || clause.may_fault || facts_[clause.guard].may_fault) return false;
    op.unit = clause.guard;
    op.zeroed = type.variables.size;
    out.ref(connector.first_cell);
    for (const u32 bound : facts_[clause.guard].binds) out.ref(binds_.rows[connector.binds + bound]);
  }
  if (const auto hiders = hiders_.find(effect.interaction); hiders != hiders_.end()) {
    BIP_ASSERT(hiders->second.size() <= kMaxHiders && std::is_sorted(hiders->second.begin(), hiders->second.end()),
               "{} interactions hide interaction {}", hiders->second.size(), effect.interaction);
    for (const rt::InteractionId interaction : hiders->second) out.ref(interaction);
    out.ops.back().hiders = static_cast<u32>(hiders->second.size());
  }
  BIP_ASSERT(
      tables_.interactions.contains(effect.interaction) && (effect.delta != 0 || !hidden_.empty() || info.searched),
      "interaction {} is touched, and nothing says why", effect.interaction);
  StepOp& made = out.ops.back();
  const std::int32_t all = -tables_.start_of(effect.interaction);
  if (exact && effect.delta < 0 && effect.interaction == fired) made.change = InteractionChange::Leaves;
  if (exact && made.unit == kNone && made.hiders == 0) {
    if (effect.delta == all) made.change = InteractionChange::Enters;
    if (effect.delta == -all) made.change = InteractionChange::Leaves;
  }
  made.is_sure = effect.delta == 0 && is_sure(info);
  return true;
}

// Ports whose flips move the counter of a broadcast: its triggers.
u32 Deriver::trigger_count(rt::InteractionId interaction, const rt::InteractionInfo& info) const {
  u32 triggers = 0;
  for (u32 k = 0; k < info.count; ++k) {
    const rt::Span<u32> above = tables_.port_out[tables_.flat_ports[info.first + k]];
    triggers += std::find(above.begin(), above.end(), rt::Tables::node_of(interaction)) != above.end() ? 1 : 0;
  }
  return triggers;
}

// A rendezvous of atoms that have one place each, and offer the ports there.
bool Deriver::is_sure(const rt::InteractionInfo& info) const {
  if (info.kind != InteractionKind::Flat) return false;
  for (u32 k = 0; k < info.count; ++k) {
    const u32 port = tables_.flat_ports[info.first + k], atom = tables_.port_atom[port];
    if (!tables_.types[tables_.atoms[atom].type].simple || tables_.atom_type(atom).places.size != 1) return false;
    if (transition_of(port) == kNone) return false;
  }
  return true;
}

// By parameter: is the port ready whenever the broadcast can fire? The only trigger is, and an atom that has one place.
std::vector<bool> Deriver::find_sure(rt::InteractionId fired) const {
  std::vector<bool> is_sure;
  u32 triggers = 0, trigger = 0;
  for (const u32 port : ports_) {
    const rt::Span<u32> above = tables_.port_out[port];
    if (std::find(above.begin(), above.end(), rt::Tables::node_of(fired)) != above.end()) {
      ++triggers;
      trigger = static_cast<u32>(is_sure.size());
    }
    is_sure.push_back(tables_.atom_type(tables_.port_atom[port]).places.size == 1);
  }
  BIP_ASSERT(triggers != 0, "broadcast {} without a trigger", fired);
  if (triggers == 1) is_sure[trigger] = true;
  return is_sure;
}

// The data of each clause, if exactly its parameters are ready.
bool Deriver::add_star_transfers(const rt::InteractionInfo& info, const std::vector<bool>& is_sure, Instance& out) {
  const u32 type_row = image_.connectors[info.row].type;
  Instance tests, codes;
  for (const u32 row : tables_.clause_order[type_row]) {
    const rt::Clause& clause = image_.connector_types[type_row].clauses[row];
    if (clause.up == kNone && clause.down == kNone) continue;
    if (clause.may_fault) return false;
    tests.clear();
    bool can_be = true;
    for (u32 param = 0; param < ports_.size(); ++param) {
      const bool takes_part = std::binary_search(clause.params.begin(), clause.params.end(), param);
      if (is_sure[param]) {
        can_be = can_be && takes_part;
        continue;
      }
      tests.add(takes_part ? StepOpKind::At : StepOpKind::Away).from =
          tables_.transitions[transition_of(ports_[param])].from;
      tests.ref(tables_.port_atom[ports_[param]]);
    }
    if (!can_be) continue;
    rt::PlanUse use;
    use.connector = info.row;
    use.clause = row;
    codes.clear();
    if (!add_transfers(&use, 1, nullptr, codes)) return false;
    if (codes.ops.empty()) continue;
    for (StepOp& op : codes.ops) op.guarded = !tests.ops.empty();
    out.append(tests);
    out.append(codes);
  }
  return true;
}

// A step of a star: each port that is enabled takes part. Ports that are always enabled fire as those of a rendezvous.
bool Deriver::add_star(rt::InteractionId fired, const rt::InteractionInfo& info, Instance& out) {
  const std::vector<bool> is_sure = find_sure(fired);
  if (!add_star_transfers(info, is_sure, out)) return false;
  std::vector<u32> sure, others;
  for (std::size_t param = 0; param < ports_.size(); ++param) (is_sure[param] ? sure : others).push_back(ports_[param]);
  ports_ = sure;
  u32 last_changed = kNone;
  if (!add_actions(out) || !add_ready(others, out, last_changed)) return false;
  const std::size_t effects = out.ops.size();
  if (!add_effects(fired, out)) return false;
  // The list changes in interaction order.
  return last_changed == kNone || effects == out.ops.size() || out.refs[out.ops[effects].first_ref] > last_changed;
}

// Adds the other ports one by one: a port takes part if its atom is at the place that the port's transition leaves.
// last_changed: the greatest interaction that may enter or leave the list.
bool Deriver::add_ready(const std::vector<u32>& ports, Instance& out, u32& last_changed) {
  Instance each;
  for (const u32 port : ports) {
    const u32 atom = tables_.port_atom[port];
    if (tables_.atom_watch[atom].size != 0 || tables_.atom_rules[atom].size != 0) return false;
    const rt::LinkedTransition& transition = tables_.transitions[transition_of(port)];
    Effect effect;
    for (u32 d = 0; d < transition.delta_count; ++d) {
      const rt::PortDelta& delta = tables_.deltas[transition.delta_first + d];
      const u32 moved = tables_.port_base(atom) + delta.port;
      if (tables_.port_watch[moved].size != 0) return false;
      for (const u32 node : tables_.port_out[moved]) {
        if (!tables_.is_interaction(node) || effect.interaction.is_valid()) return false;
        effect = {rt::Tables::interaction_at(node), delta.transition != kNone ? 1 : -1};
      }
    }
    if (effect.interaction.is_valid()) {
      const rt::InteractionInfo info = tables_.interactions[effect.interaction];
      const bool exact = info.kind == InteractionKind::Flat || info.kind == InteractionKind::Port;
      if (!exact || info.searched || hiders_.contains(effect.interaction) || hidden_.contains(effect.interaction))
        return false;
      if (effect.delta != -tables_.start_of(effect.interaction)) return false;
    }
    const u32 action = transition.source->action;
    if (action != kNone && facts_[action].may_fault) return false;
    StepOp& op = each.add(StepOpKind::Ready);
    op.unit = action;
    op.from = transition.from;
    op.to = transition.to;
    op.delta = effect.delta;
    each.ref(atom);
    if (action != kNone) each.ref(image_.atoms[atom].first_cell);
    if (effect.interaction.is_valid()) each.ref(effect.interaction);
  }
  // The list changes in interaction order: one group of parameters changes it, in that order.
  Instance folded;
  std::vector<std::int32_t> strides;
  fold(each, 1, folded, strides);
  u32 changing = 0;
  for (const StepOp& op : folded.ops) {
    if (op.delta == 0) continue;
    ++changing;
    // The operand that is the interaction.
    const u32 last = op.first_ref + op.refs - 1;
    if (folded.refs[op.first_ref] > 1 && strides[last] <= 0) return false;
    last_changed = folded.refs[last] + (folded.refs[op.first_ref] - 1) * static_cast<u32>(strides[last]);
  }
  // Folded for good in derive_steps: here the parameters one by one.
  out.append(each);
  return changing <= 1;
}

}  // namespace bip::steps
