// Priorities between interactions, as the core has them (runtime/core/priorities.hpp), and the machine put together.
#include <algorithm>

#include "compiler/verify/machine_builder.hpp"

namespace bip::verify {

// Does the step's interaction match that side of the rule?
Signal MachineBuilder::matches(const rt::Priority& rule, bool high, const MachineStep& step, const std::vector<Signal>& params) {
  const u32 connector = tables_.slots[step.slot].row;
  const rt::Pattern& pattern = high ? rule.high : rule.low;
  const rt::Pattern& other = high ? rule.low : rule.high;
  if (pattern.any_connector) {
    if (image_.connectors[connector].parent != rule.parent) return kFalse;
    return other.any_connector ? kTrue : negated(matches(rule, !high, step, params));
  }
  if (pattern.connector != connector) return kFalse;
  if (pattern.any_interaction) return kTrue;
  Signal result = kTrue;
  for (u32 p = 0; p < params.size(); ++p) {
    const bool named = std::binary_search(pattern.params.begin(), pattern.params.end(), p);
    if (high && named) result = c_.both(result, params[p]);
    if (!high && !named) result = c_.both(result, negated(params[p]));
  }
  return result;
}

void MachineBuilder::apply_priorities() {
  const rt::PriorityTables rules = rt::link_priorities(tables_);
  if (rules.count == 0) return;
  const auto is_connector = [&](const MachineStep& step) { return step.slot < tables_.connector_slots; };
  std::vector<Signal> guard, hides;
  for (u32 r = 0; r < rules.count; ++r) {
    const rt::Priority& rule = image_.priorities[r];
    Variables variables;
    variables.bind = [&](u32 k) {
      const u32 row = image_.binds[rule.binds + k].slot;
      return now_[atom_of_slot_[row]].slots[row - image_.atoms[atom_of_slot_[row]].slot_base];
    };
    guard.push_back(code_.test(system_.priorities[PriorityId(std::size_t{r})].guard, variables, kTrue, state_fault_));
    Signal above = kFalse;
    for (std::size_t s = 0; s < m_.steps.size(); ++s) {
      if (is_connector(m_.steps[s])) above = c_.either(above, c_.both(m_.steps[s].possible, matches(rule, true, m_.steps[s], params_[s])));
    }
    hides.push_back(c_.both(guard[r], above));
  }
  // Along chains of rules that hold; and cycles of them, which are faults.
  std::vector<Signal> on_cycle;
  for (u32 r = 0; r < rules.count; ++r) on_cycle.push_back(rules.cyclic[rules.component[r]] != 0 ? guard[r] : kFalse);
  for (u32 round = 0; round <= rules.count; ++round) {
    std::vector<Signal> next = hides, left(rules.count, kFalse);
    for (u32 r = 0; r < rules.count; ++r) {
      for (u32 s : rules.next[r]) next[r] = c_.either(next[r], c_.both(guard[r], hides[s]));
      for (u32 s : rules.previous[r]) left[r] = c_.either(left[r], c_.both(guard[r], on_cycle[s]));
      left[r] = c_.both(left[r], on_cycle[r]);
    }
    if (next == hides && left == on_cycle) break;
    hides = std::move(next);
    on_cycle = std::move(left);
  }
  state_fault_ = c_.either(state_fault_, c_.any(on_cycle));
  std::vector<Signal> visible;
  for (std::size_t s = 0; s < m_.steps.size(); ++s) {
    Signal here = m_.steps[s].possible;
    for (u32 r = 0; r < rules.count && is_connector(m_.steps[s]); ++r) {
      here = c_.both(here, negated(c_.both(hides[r], matches(image_.priorities[r], false, m_.steps[s], params_[s]))));
    }
    visible.push_back(here);
  }
  for (std::size_t s = 0; s < m_.steps.size(); ++s) m_.steps[s].possible = visible[s];
}

Machine MachineBuilder::build() {
  add_state();
  add_ports();
  add_connectors();
  if (!m_.unsupported.empty()) return std::move(m_);
  add_internal_ports();
  apply_priorities();
  m_.connector_can.assign(system_.connectors.size(), kFalse);
  Signal some = kFalse, fault = kFalse;
  for (std::size_t s = 0; s < m_.steps.size(); ++s) {
    MachineStep& step = m_.steps[s];
    step.possible = c_.both(step.possible, negated(state_fault_));
    some = c_.either(some, step.possible);
    if (step.slot < tables_.connector_slots) {
      Signal& can = m_.connector_can[tables_.slots[step.slot].row];
      can = c_.either(can, step.possible);
    }
    const Signal taken = c_.both(step.chosen, step.possible);
    fault = c_.either(fault, c_.both(taken, step_fault_[s]));
    m_.lost = c_.either(m_.lost, c_.both(taken, step_lost_[s]));
    step.fine = c_.both(step.possible, negated(c_.either(step_fault_[s], step_lost_[s])));
  }
  m_.state_fault = state_fault_;
  m_.stuck = c_.both(negated(some), negated(state_fault_));
  m_.error = c_.any({state_fault_, fault, guard_fault_});
  finish_state();
  m_.vague = code_.vague();
  if (c_.is_full()) m_.unsupported = "the system is too large for a circuit";
  return std::move(m_);
}

Machine build_machine(const System& system, const rt::Image& image) { return MachineBuilder(system, image).build(); }

}  // namespace bip::verify
