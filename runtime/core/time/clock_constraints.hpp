// Conditions on clocks without an instant: what the explorer of timed models (explore/zones.hpp) asks instead of "is it
// enabled now". Which transitions are marked and enabled by data, and what each then demands of the clocks, as whole
// ticks: `x > 5s` is x >= 5s and 1 ns, as everywhere in the core. Limits that are not constants are measured in the
// state at hand. Functions return false after a fault.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"
#include "runtime/core/time/interval.hpp"

namespace bip::rt {

struct CoreParts;

inline constexpr i64 kNoBound = INT64_MAX;      // of high; -kNoBound of low
inline constexpr i64 kFarLimit = i64{1} << 59;  // beyond it a limit counts as infinite: 18 years
/// A clock (minus another) from low to high, in ticks.
struct ClockBound {
  u32 clock, minus;  // of the atom's type; minus: kNone: 0
  i64 low = -kNoBound, high = kNoBound;
};
/// A condition on an atom's clocks as its data are now.
struct MeasuredGuard {
  bool can_hold = true;  // false: whatever the clocks are
  std::vector<ClockBound> bounds;
};
/// A transition that the atom's marking and data enable, at whatever instant.
struct TimedTransition {
  u32 row = kNone, port = kNone;  // of the type
  Urgency urgency = Urgency::Lazy;
  MeasuredGuard when;
};

class ClockConstraints {
 public:
  explicit ClockConstraints(CoreParts& core) : core_(core) {}

  [[nodiscard]] bool measure(u32 atom, const TimeGuard& when, MeasuredGuard& out);
  /// Finds the labelled transitions that the atom's marking and data enable, whether it is busy or not and whether
  /// events wait or not.
  [[nodiscard]] bool timed_transitions(u32 atom, std::vector<TimedTransition>& out);
  /// Finds the invariants in scope that bound clocks.
  [[nodiscard]] bool timed_invariants(u32 atom, std::vector<MeasuredGuard>& out);
  /// Finds what the atom waits for after a transition (a row of its type's; kNone: after `initial`).
  [[nodiscard]] bool measured_resume(u32 atom, u32 row, MeasuredGuard& out);

 private:
  CoreParts& core_;
};

}  // namespace bip::rt
