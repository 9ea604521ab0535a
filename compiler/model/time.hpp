// Time in atom types: clocks, bounds of guards on them, urgency, `resume`, `@async`, external events
// (compiler/docs/language_meaning.md, section 7).
//
// Executors of code know nothing of clocks. A clock owns three hidden variables of its atom, and an assignment to it is
// two stores: the value, in the clock's unit, and that there is one; the caller of the action looks there and zeroes
// them again. A bound compares a clock, or the difference of two, with a limit: a constant in ticks of 1 ns, or a
// hidden variable into which `measure`, a body of stores, puts the limit in the clock's unit. Conditions on data stay
// what they were: guards.
#pragma once
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/model/code.hpp"

namespace bip {

/// Hidden variables of a clock, from Clock::variable on.
enum class ClockVariable : std::uint8_t { Value, IsSet, Speed };  // float, bool, float
inline constexpr std::uint32_t kClockVariables = 3;
struct Clock {
  std::string name;
  std::int64_t unit = 1'000'000'000;  // ticks
  std::uint32_t variable = 0;         // the first of its hidden variables
  Loc loc{};
};

enum class BoundOp : std::uint8_t { Lt, Le, Gt, Ge, Eq };
[[nodiscard]] const char* name_of(BoundOp op);  // "lt"
/// clock - minus op limit
struct Bound {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::uint32_t clock = 0;
  std::uint32_t minus = kNone;  // a second clock, of the same unit
  BoundOp op = BoundOp::Ge;
  std::int64_t ticks = 0;          // the limit, if `variable` is kNone
  std::uint32_t variable = kNone;  // a hidden variable: float, in the clock's unit
  Loc loc{};
};
/// What a condition says of time: all of its bounds hold.
struct TimeGuard {
  std::vector<Bound> bounds{};
  StmtId measure{};  // invalid: every limit is a constant. Writes the variables of the bounds
  [[nodiscard]] bool empty() const { return bounds.empty(); }
};

enum class Urgency : std::uint8_t { Lazy, Delayable, Eager };
[[nodiscard]] const char* name_of(Urgency urgency);
/// After the step the atom is busy until this holds.
struct Resume {
  bool present = false;
  ExprId guard{};  // invalid: true
  TimeGuard when{};
  Loc loc{};
};
/// `@async`: the action runs beside the others, and the atom is busy until it returns.
struct Async {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  bool present = false;
  std::int64_t budget = -1;       // ticks that it may take; -1: none is given
  std::uint32_t overrun = kNone;  // a port for events, without variables: gets one when the budget is over
};
/// Do the ports of an interaction resume together?
enum class ResumeMode : std::uint8_t { Async, Sync };

/// What happens to an event from outside that no enabled port takes.
enum class EventPolicy : std::uint8_t { Remember, Ignore, Error };
[[nodiscard]] const char* name_of(EventPolicy policy);

/// The largest limit or value: 146 years.
inline constexpr std::int64_t kMaxTicks = std::int64_t{1} << 62;
/// A value in a clock's unit in ticks, rounded to the nearest one. False: no number, or beyond kMaxTicks.
[[nodiscard]] inline bool to_ticks(double value, std::int64_t unit, std::int64_t& ticks) {
  const double exact = value * static_cast<double>(unit);
  if (!(std::fabs(exact) <= static_cast<double>(kMaxTicks))) return false;
  // A whole number of units is exact beyond what a double holds.
  const bool is_whole = std::fabs(value) <= 9007199254740992.0 && value == std::floor(value);
  ticks = is_whole ? static_cast<std::int64_t>(value) * unit : std::llround(exact);
  return true;
}

}  // namespace bip
