// Priorities between the ports of one atom, and its invariants (compiler/docs/language_meaning.md, section 2).
//
// Rules with true guards are edges between ports. A port is hidden iff an enabled port can be reached from it; ports on
// the way need not be enabled. A cycle of such edges is a fault. Cost: the rules of the type (a wildcard counts as an
// edge for each port) whenever the atom's ports are looked at; types without rules never come here.
#include <algorithm>

#include "runtime/core/core.hpp"

namespace bip::rt {

namespace {

// Calls visit(low, high) for each pair of ports that the rule orders.
template <class Visit>
void each_edge(const AtomPriority& rule, u32 ports, const Visit& visit) {
  if (rule.low != kNone && rule.high != kNone) {
    visit(rule.low, rule.high);
    return;
  }
  for (u32 port = 0; port < ports; ++port) {
    if (rule.low == kNone && port != rule.high) visit(port, rule.high);
    if (rule.high == kNone && port != rule.low) visit(rule.low, port);
  }
}

}  // namespace

bool Core::hide_ports(u32 atom, u32* transition_of_port) {
  const AtomType& type = tables_.atom_type(atom);
  const u32 ports = type.ports.size;
  Cell* self = all_.data() + atoms_[atom].first_cell;
  rule_holds_.assign(type.priorities.size, 1);
  rule_in_.assign(ports, 0);
  for (u32 row = 0; row < type.priorities.size; ++row) {
    const AtomPriority& rule = type.priorities[row];
    if (const Code guard = tables_.code(rule.guard); guard.fn != nullptr) {
      const std::int32_t status = guard.fn(guard.context, self, all_.data(), nullptr);
      if (status >= 2) return fail_code(status, atom, kNone, nullptr, rule.name);
      rule_holds_[row] = static_cast<std::uint8_t>(status);
    }
    if (rule_holds_[row] != 0) each_edge(rule, ports, [&](u32, u32 high) { ++rule_in_[high]; });
  }
  // Kahn, from below: a port comes after all that are directly below it. What is never reached is on a cycle or above
  // one.
  rule_order_.clear();
  for (u32 port = 0; port < ports; ++port) {
    if (rule_in_[port] == 0) rule_order_.push_back(port);
  }
  for (std::size_t at = 0; at < rule_order_.size(); ++at) {
    for (u32 row = 0; row < type.priorities.size; ++row) {
      if (rule_holds_[row] == 0) continue;
      each_edge(type.priorities[row], ports, [&](u32 low, u32 high) {
        if (low == rule_order_[at] && --rule_in_[high] == 0) rule_order_.push_back(high);
      });
    }
  }
  if (rule_order_.size() != ports) {
    std::vector<u32> rules;
    for (u32 row = 0; row < type.priorities.size; ++row) {
      bool inside = false;
      each_edge(type.priorities[row], ports,
                [&](u32 low, u32 high) { inside |= rule_in_[low] != 0 && rule_in_[high] != 0; });
      if (inside && rule_holds_[row] != 0) rules.push_back(row);
    }
    return fail_atom_rules(atom, rules);
  }
  // From above: is something enabled above the port?
  std::vector<u32>& covered = rule_in_;  // all zero now
  for (std::size_t at = rule_order_.size(); at-- > 0;) {
    for (u32 row = 0; row < type.priorities.size; ++row) {
      if (rule_holds_[row] == 0) continue;
      each_edge(type.priorities[row], ports, [&](u32 low, u32 high) {
        if (low == rule_order_[at] && (covered[high] != 0 || transition_of_port[high] != kNone)) covered[low] = 1;
      });
    }
  }
  for (u32 port = 0; port < ports; ++port) {
    if (covered[port] != 0) transition_of_port[port] = kNone;
  }
  return true;
}

bool Core::is_in_scope(u32 atom, const Invariant& invariant) const {
  if (invariant.scope == InvariantScope::Always) return true;
  if (!std::all_of(invariant.places.begin(), invariant.places.end(), [&](u32 place) { return is_marked(atom, place); }))
    return false;
  if (invariant.scope == InvariantScope::From) return true;
  u32 marked = 0;
  for (u32 place = 0; place < tables_.atom_type(atom).places.size; ++place) marked += is_marked(atom, place) ? 1u : 0u;
  return marked == invariant.places.size;
}

bool Core::check_invariants(u32 atom, const LinkedTransition* fired) {
  const AtomType& type = tables_.atom_type(atom);
  const Transition* transition = fired == nullptr ? nullptr : fired->source;
  for (const Invariant& invariant : type.invariants) {
    if (!is_in_scope(atom, invariant)) continue;
    const Code condition = tables_.code(invariant.condition);
    if (condition.fn == nullptr) continue;
    const std::int32_t status =
        condition.fn(condition.context, all_.data() + atoms_[atom].first_cell, all_.data(), nullptr);
    if (status >= 2) return fail_code(status, atom, kNone, transition, invariant.name);
    if (status == 0) return fail_invariant(atom, invariant, transition);
  }
  return true;
}

}  // namespace bip::rt
