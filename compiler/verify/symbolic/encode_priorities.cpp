// Priorities between interactions, as the core has them (runtime/core/link/priorities.hpp), and the transition system
// put together.
#include <algorithm>

#include "compiler/system/inner_priorities.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/symbolic/transition_system_builder.hpp"

namespace bip::verify {

// Does the step's interaction match that side of the rule?
Signal TransitionSystemBuilder::matches(const rt::Priority& rule, RuleSide side, const SystemStep& step,
                                        const std::vector<Signal>& params) {
  const u32 connector = tables_.interactions[step.interaction].row;
  const rt::Pattern& pattern = side == RuleSide::High ? rule.high : rule.low;
  const rt::Pattern& other = side == RuleSide::High ? rule.low : rule.high;
  if (pattern.any_connector) {
    if (image_.connectors[connector].parent != rule.parent) return kFalse;
    return other.any_connector
               ? kTrue
               : negated(matches(rule, side == RuleSide::High ? RuleSide::Low : RuleSide::High, step, params));
  }
  if (pattern.connector != connector) return kFalse;
  if (pattern.any_interaction) return kTrue;
  Signal result = kTrue;
  for (u32 p = 0; p < params.size(); ++p) {
    const bool named = std::binary_search(pattern.params.begin(), pattern.params.end(), p);
    if (side == RuleSide::High && named) result = aig_.make_and(result, params[p]);
    if (side == RuleSide::Low && !named) result = aig_.make_and(result, negated(params[p]));
  }
  return result;
}

void TransitionSystemBuilder::apply_priorities() {
  const rt::PriorityTables rules = rt::link_priorities(tables_);
  if (rules.count == 0) return;
  const auto is_connector = [&](const SystemStep& step) { return tables_.is_of_connector(step.interaction); };
  std::vector<Signal> guard, hides;
  for (u32 r = 0; r < rules.count; ++r) {
    const rt::Priority& rule = image_.priorities[r];
    Variables variables;
    variables.bind = [&](u32 k) {
      const u32 row = image_.binds[rule.binds + k].cell;
      return now_[atom_of_cell_[row]].variables[row - image_.atoms[atom_of_cell_[row]].first_cell];
    };
    guard.push_back(code_.test(system_.priorities[PriorityId(std::size_t{r})].guard, variables, kTrue, state_fault_));
    Signal above = kFalse;
    for (std::size_t s = 0; s < transition_system_.steps.size(); ++s) {
      if (is_connector(transition_system_.steps[s]))
        above =
            aig_.make_or(above, aig_.make_and(transition_system_.steps[s].possible,
                                              matches(rule, RuleSide::High, transition_system_.steps[s], params_[s])));
    }
    hides.push_back(aig_.make_and(guard[r], above));
  }
  // Along chains of rules that hold; and cycles of them, which are faults.
  std::vector<Signal> on_cycle;
  for (u32 r = 0; r < rules.count; ++r) on_cycle.push_back(rules.cyclic[rules.component[r]] != 0 ? guard[r] : kFalse);
  for (u32 round = 0; round <= rules.count; ++round) {
    std::vector<Signal> next = hides, left(rules.count, kFalse);
    for (u32 r = 0; r < rules.count; ++r) {
      for (u32 s : rules.next[r]) next[r] = aig_.make_or(next[r], aig_.make_and(guard[r], hides[s]));
      for (u32 s : rules.previous[r]) left[r] = aig_.make_or(left[r], aig_.make_and(guard[r], on_cycle[s]));
      left[r] = aig_.make_and(left[r], on_cycle[r]);
    }
    if (next == hides && left == on_cycle) break;
    hides = std::move(next);
    on_cycle = std::move(left);
  }
  state_fault_ = aig_.make_or(state_fault_, aig_.make_or_of(on_cycle));
  std::vector<Signal> visible;
  for (std::size_t s = 0; s < transition_system_.steps.size(); ++s) {
    Signal is_visible = transition_system_.steps[s].possible;
    for (u32 r = 0; r < rules.count && is_connector(transition_system_.steps[s]); ++r) {
      is_visible =
          aig_.make_and(is_visible, negated(aig_.make_and(hides[r], matches(image_.priorities[r], RuleSide::Low,
                                                                            transition_system_.steps[s], params_[s]))));
    }
    visible.push_back(is_visible);
  }
  for (std::size_t s = 0; s < transition_system_.steps.size(); ++s) transition_system_.steps[s].possible = visible[s];
}

TransitionSystem TransitionSystemBuilder::build() {
  transition_system_.unsupported = system::first_inner_priority(system_);
  if (!transition_system_.unsupported.empty()) return std::move(transition_system_);
  add_state();
  add_ports();
  add_connectors();
  if (!transition_system_.unsupported.empty() || transition_system_.is_stopped) return std::move(transition_system_);
  add_internal_ports();
  apply_priorities();
  transition_system_.connector_can.assign(system_.connectors.size(), kFalse);
  Signal some = kFalse, fault = kFalse;
  for (std::size_t s = 0; s < transition_system_.steps.size(); ++s) {
    SystemStep& step = transition_system_.steps[s];
    step.possible = aig_.make_and(step.possible, negated(state_fault_));
    some = aig_.make_or(some, step.possible);
    if (tables_.is_of_connector(step.interaction)) {
      Signal& can = transition_system_.connector_can[tables_.interactions[step.interaction].row];
      can = aig_.make_or(can, step.possible);
    }
    const Signal taken = aig_.make_and(step.chosen, step.possible);
    fault = aig_.make_or(fault, aig_.make_and(taken, step_fault_[s]));
    transition_system_.lost = aig_.make_or(transition_system_.lost, aig_.make_and(taken, step_lost_[s]));
    step.fine = aig_.make_and(step.possible, negated(aig_.make_or(step_fault_[s], step_lost_[s])));
  }
  transition_system_.state_fault = state_fault_;
  const Signal is_end = final_state();
  transition_system_.ended = aig_.make_and(negated(some), negated(state_fault_));
  transition_system_.stuck = aig_.make_and(transition_system_.ended, negated(is_end));
  transition_system_.error = aig_.make_or_of({state_fault_, fault, guard_fault_});
  finish_state();
  transition_system_.imprecisions = code_.imprecisions();
  if (aig_.is_full()) {
    transition_system_.unsupported =
        "its circuit takes more than " + std::to_string(megabytes_) + " MB (--memory allows more)";
  }
  // What proofs add later is small beside it, and they do not ask whether it is full.
  aig_.set_bound(Aig::kMostNodes);
  return std::move(transition_system_);
}

// Each atom is at final places only.
Signal TransitionSystemBuilder::final_state() {
  Signal final = kTrue;
  for (std::size_t atom = 0; atom < system_.atoms.size(); ++atom) {
    const AtomType& type = system_.atom_types[system_.atoms[AtomId(atom)].type];
    if (type.final_places.empty()) return kFalse;
    for (u32 place = 0; place < type.places.size(); ++place) {
      if (!std::binary_search(type.final_places.begin(), type.final_places.end(), place))
        final = aig_.make_and(final, negated(transition_system_.marks[atom][place]));
    }
  }
  return final;
}

TransitionSystem build_transition_system(const System& system, const rt::Image& image, std::size_t megabytes,
                                         const CancellationToken& cancellation) {
  return TransitionSystemBuilder(system, image, megabytes, cancellation).build();
}

}  // namespace bip::verify
