// See clock_constraints.hpp.
#include "runtime/core/time/clock_constraints.hpp"

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"

namespace bip::rt {

namespace {

// Limits that no clock will see are none.
void add_bound(const Bound& bound, i64 limit, MeasuredGuard& out) {
  const bool is_strict = bound.op == BoundOp::Lt || bound.op == BoundOp::Gt;
  ClockBound measured{bound.clock, bound.minus};
  if (bound.op == BoundOp::Lt || bound.op == BoundOp::Le || bound.op == BoundOp::Eq) {
    if (limit < -kFarLimit) out.can_hold = false;
    if (limit <= kFarLimit) measured.high = limit - (is_strict ? 1 : 0);
  }
  if (bound.op == BoundOp::Gt || bound.op == BoundOp::Ge || bound.op == BoundOp::Eq) {
    if (limit > kFarLimit) out.can_hold = false;
    if (limit >= -kFarLimit) measured.low = limit + (is_strict ? 1 : 0);
  }
  BIP_ASSERT(bound.minus != bound.clock, "clock {} minus itself", bound.clock);
  if (measured.high != kNoBound || measured.low != -kNoBound) out.bounds.push_back(measured);
}

}  // namespace

bool ClockConstraints::measure(u32 atom, const TimeGuard& when, MeasuredGuard& out) {
  out.can_hold = true;
  out.bounds.clear();
  if (when.bounds.size == 0) return true;
  if (!core_.clocks.measure_limits(atom, when)) return false;
  for (const Bound& bound : when.bounds) {
    i64 limit = 0;
    if (!core_.clocks.take_limit(atom, bound, limit)) out.can_hold = false;
    add_bound(bound, limit, out);
  }
  return true;
}

bool ClockConstraints::timed_transitions(u32 atom, std::vector<TimedTransition>& out) {
  out.clear();
  const LinkedType& type = core_.tables.types[core_.atoms[atom].type];
  const AtomTime& time = *core_.tables.atom_type(atom).time;
  BIP_ASSERT(time.transitions.size == type.transition_count, "{} of {} transitions have times", time.transitions.size,
             type.transition_count);
  for (u32 row = 0; row < type.transition_count; ++row) {
    const LinkedTransition& transition = core_.tables.transitions[type.first_transition + row];
    if (transition.port == kNone) continue;
    bool is_marked_from = true;
    if (type.mark_words == 0) is_marked_from = core_.memory.places[atom] == transition.from;
    bool is_enabled = false;
    if (!is_marked_from) continue;
    if (!core_.atom_steps.is_enabled_from(atom, transition, is_enabled)) return false;
    if (!is_enabled) continue;
    TimedTransition timed{row, transition.port, time.transitions[row].urgency, {}};
    if (!measure(atom, time.transitions[row].when, timed.when)) return false;
    if (timed.when.can_hold) out.push_back(std::move(timed));
  }
  return true;
}

bool ClockConstraints::timed_invariants(u32 atom, std::vector<MeasuredGuard>& out) {
  out.clear();
  const AtomType& type = core_.tables.atom_type(atom);
  for (u32 row = 0; row < type.invariants.size; ++row) {
    if (type.time->invariants[row].bounds.size == 0 || !core_.atom_steps.is_in_scope(atom, type.invariants[row]))
      continue;
    out.emplace_back();
    if (!measure(atom, type.time->invariants[row], out.back())) return false;
  }
  return true;
}

bool ClockConstraints::measured_resume(u32 atom, u32 row, MeasuredGuard& out) {
  const AtomTime& time = *core_.tables.atom_type(atom).time;
  const Resume& resume = row == kNone ? time.initial : time.transitions[row].resume;
  BIP_ASSERT(row == kNone || row < core_.tables.atom_type(atom).transitions.size, "transition {} of atom {}", row,
             atom);
  out = {};
  if (!resume.present) return true;
  if (!measure(atom, resume.when, out)) return false;
  const Code guard = core_.tables.code(resume.guard);
  if (guard.fn == nullptr) return true;
  const std::int32_t status =
      guard.fn(guard.context, core_.memory.cells.from(core_.atoms[atom].first_cell), core_.memory.cells.all(), nullptr);
  if (status >= 2) return core_.faults.fail_code(status, atom, kNone, nullptr, "what `resume` waits for");
  if (status == 0) out.can_hold = false;
  return true;
}

}  // namespace bip::rt
