// See atom_priorities.hpp.
#include "runtime/core/state/atom_priorities.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"
#include "runtime/core/graph_algorithms.hpp"

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

bool AtomPriorities::hide_ports(u32 atom, u32* transition_of_port) {
  const AtomType& type = core_.tables.atom_type(atom);
  const u32 ports = type.ports.size;
  Cell* self = core_.memory.cells.from(core_.atoms[atom].first_cell);
  rule_holds_.assign(type.priorities.size, 1);
  rule_in_.assign(ports, 0);
  for (u32 row = 0; row < type.priorities.size; ++row) {
    const AtomPriority& rule = type.priorities[row];
    if (const Code guard = core_.tables.code(rule.guard); guard.fn != nullptr) {
      const std::int32_t status = guard.fn(guard.context, self, core_.memory.cells.all(), nullptr);
      if (status >= 2) return core_.faults.fail_code(status, atom, kNone, nullptr, rule.name);
      rule_holds_[row] = static_cast<std::uint8_t>(status);
    }
    BIP_ASSERT(rule.low != kNone || rule.high != kNone, "rule {} orders no ports", row);
    if (rule_holds_[row] != 0) each_edge(rule, ports, [&](u32, u32 high) { ++rule_in_[high]; });
  }
  // A port comes after all that are directly below it. What is not in the order is on a cycle or above one.
  const bool is_acyclic = topological_order(rule_in_, rule_order_, [&](u32 port, const auto& see) {
    for (u32 row = 0; row < type.priorities.size; ++row) {
      if (rule_holds_[row] == 0) continue;
      each_edge(type.priorities[row], ports, [&](u32 low, u32 high) {
        if (low == port) see(high);
      });
    }
  });
  if (!is_acyclic) {
    std::vector<u32> rules;
    for (u32 row = 0; row < type.priorities.size; ++row) {
      bool inside = false;
      each_edge(type.priorities[row], ports,
                [&](u32 low, u32 high) { inside |= rule_in_[low] != 0 && rule_in_[high] != 0; });
      if (inside && rule_holds_[row] != 0) rules.push_back(row);
    }
    return core_.faults.fail_atom_rules(atom, rules);
  }
  // From above: is something enabled above the port?
  std::vector<u32>& covered = rule_in_;  // all zero now
  BIP_ASSERT(std::count(covered.begin(), covered.end(), 0u) == static_cast<std::ptrdiff_t>(ports),
             "of {} ports some are above others still", ports);
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

}  // namespace bip::rt
