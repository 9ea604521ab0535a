// Conditions on clocks without an instant: what the explorer of timed models (explore/zones.hpp) asks instead of "is it
// enabled now". Which transitions are marked and enabled by data, and what each then demands of the clocks, as whole
// ticks: `x > 5s` is x >= 5s and 1 ns, as everywhere in the core. Limits that are not constants are measured in the
// state at hand.
#include "runtime/core/core.hpp"

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
  if (measured.high != kNoBound || measured.low != -kNoBound) out.bounds.push_back(measured);
}

}  // namespace

bool Core::measure(u32 atom, const TimeGuard& when, MeasuredGuard& out) {
  out.can_hold = true;
  out.bounds.clear();
  if (when.bounds.size == 0) return true;
  if (!measure_limits(atom, when)) return false;
  for (const Bound& bound : when.bounds) {
    i64 limit = 0;
    if (!take_limit(atom, bound, limit)) out.can_hold = false;
    add_bound(bound, limit, out);
  }
  return true;
}

bool Core::timed_transitions(u32 atom, std::vector<TimedTransition>& out) {
  out.clear();
  const LinkedType& type = tables_.types[atoms_[atom].type];
  const AtomTime& time = *tables_.atom_type(atom).time;
  for (u32 row = 0; row < type.transition_count; ++row) {
    const LinkedTransition& transition = tables_.transitions[type.first_transition + row];
    if (transition.port == kNone) continue;
    bool is_marked_from = true;
    if (type.mark_words == 0) is_marked_from = places_[atom] == transition.from;
    bool is_enabled = false;
    if (!is_marked_from) continue;
    if (!is_enabled_from(atom, transition, is_enabled)) return false;
    if (!is_enabled) continue;
    TimedTransition timed{row, transition.port, time.transitions[row].urgency, {}};
    if (!measure(atom, time.transitions[row].when, timed.when)) return false;
    if (timed.when.can_hold) out.push_back(std::move(timed));
  }
  return true;
}

bool Core::timed_invariants(u32 atom, std::vector<MeasuredGuard>& out) {
  out.clear();
  const AtomType& type = tables_.atom_type(atom);
  for (u32 row = 0; row < type.invariants.size; ++row) {
    if (type.time->invariants[row].bounds.size == 0 || !is_in_scope(atom, type.invariants[row])) continue;
    out.emplace_back();
    if (!measure(atom, type.time->invariants[row], out.back())) return false;
  }
  return true;
}

bool Core::measured_resume(u32 atom, u32 row, MeasuredGuard& out) {
  const AtomTime& time = *tables_.atom_type(atom).time;
  const Resume& resume = row == kNone ? time.initial : time.transitions[row].resume;
  out = {};
  if (!resume.present) return true;
  if (!measure(atom, resume.when, out)) return false;
  const Code guard = tables_.code(resume.guard);
  if (guard.fn == nullptr) return true;
  const std::int32_t status = guard.fn(guard.context, all_.data() + atoms_[atom].first_cell, all_.data(), nullptr);
  if (status >= 2) return fail_code(status, atom, kNone, nullptr, "what `resume` waits for");
  if (status == 0) out.can_hold = false;
  return true;
}

}  // namespace bip::rt
