// Intervals of instants, and the instants at which a bound on a clock that runs holds. Integers throughout: instants
// and values of clocks are ticks of 1 ns, speeds multiples of 2^-32, so no run drifts and every machine computes the
// same.
#pragma once
#include <algorithm>
#include <cstdint>

#include "bip/assert.hpp"
#include "bip/image_time.hpp"

namespace bip::rt {

using i64 = std::int64_t;
__extension__ using Int128 = __int128;

inline constexpr i64 kForever = INT64_MAX;
inline constexpr i64 kMaxTicks = i64{1} << 62;  // of a clock's value, a limit
inline constexpr i64 kUnitSpeed = i64{1} << 32;
inline constexpr i64 kMaxSpeed = kUnitSpeed << 20;

/// Both ends belong to it; empty if low > high. A flag says that the source left the end out: `x > 5` begins one tick
/// after what is shown.
struct Interval {
  i64 low = 0;
  i64 high = kForever;
  bool low_open = false, high_open = false;

  [[nodiscard]] bool empty() const { return low > high; }
  [[nodiscard]] bool has(i64 t) const { return low <= t && t <= high; }
  void meet(const Interval& other) {
    if (other.low > low || (other.low == low && other.low_open)) low = other.low, low_open = other.low_open;
    if (other.high < high) high = other.high, high_open = other.high_open;
  }
  static Interval none() { return {1, 0, false, false}; }
};

namespace interval {
inline Int128 floor_div(Int128 a, Int128 b) { return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0); }
/// The instant `ticks` after now; no earlier, no later than kForever.
inline i64 after(i64 now, Int128 ticks) {
  const Int128 at = static_cast<Int128>(now) + (ticks < 0 ? Int128{0} : ticks);
  return at >= kForever ? kForever : static_cast<i64>(at);
}
/// The first t, a number of ticks, with fraction + speed * t >= missing << 32. Nearly all clocks run at speed 1, and a
/// division of 128 bits is a call.
inline Int128 ticks_for(Int128 missing, i64 speed, i64 fraction) {
  return speed == kUnitSpeed ? missing : -floor_div(fraction - (missing << 32), speed);
}
/// floor(value + fraction + speed * t) >= limit, from now on; the fraction is in 2^-32, and below 1.
inline Interval at_least(i64 now, Int128 missing, i64 speed, i64 fraction) {
  if (speed == 0 || (missing <= 0 && speed > 0))
    return missing <= 0 ? Interval{now, kForever, false, false} : Interval::none();
  // fraction + speed * t >= missing
  if (speed > 0) {
    const i64 low = after(now, ticks_for(missing, speed, fraction));
    return low == kForever ? Interval::none() : Interval{low, kForever, false, false};
  }
  if (missing > 0) return Interval::none();
  BIP_ASSERT(speed < 0, "speed {}", speed);
  return {now, after(now, ((-missing << 32) + fraction) / -static_cast<Int128>(speed)), false, false};
}
/// floor(value + fraction + speed * t) <= limit: what at_least leaves, one tick of the clock further.
inline Interval at_most(i64 now, Int128 missing, i64 speed, i64 fraction) {
  const Int128 beyond = missing + 1;  // fraction + speed * t < beyond
  if (speed == 0) return beyond > 0 ? Interval{now, kForever, false, false} : Interval::none();
  if (speed > 0) {
    if (beyond <= 0) return Interval::none();
    const i64 end = after(now, ticks_for(beyond, speed, fraction));
    return {now, end == kForever ? kForever : end - 1, false, false};
  }
  if (beyond > 0) return {now, kForever, false, false};
  BIP_ASSERT(speed < 0, "speed {}", speed);
  const i64 low = after(now, ((-beyond << 32) + fraction) / -static_cast<Int128>(speed) + 1);
  return low == kForever ? Interval::none() : Interval{low, kForever, false, false};
}
}  // namespace interval

/// The instants from `now` on at which a clock compares so with the limit. `exact` is its value in 2^-32 (of two
/// clocks, their difference), and `speed` its speed (signed: of a difference). The value of a tick ago says whether a
/// strict bound begins at this very instant.
[[nodiscard]] inline Interval instants_of(i64 now, Int128 exact, i64 speed, BoundOp op, i64 limit) {
  const Int128 missing = static_cast<Int128>(limit) - (exact >> 32), before = (exact - speed) >> 32;
  const auto fraction = static_cast<i64>(exact & (kUnitSpeed - 1));
  Interval all{now, kForever, false, false};
  if (op == BoundOp::Eq || op == BoundOp::Ge || op == BoundOp::Gt) {
    const bool is_strict = op == BoundOp::Gt;
    Interval part = interval::at_least(now, missing + (is_strict ? 1 : 0), speed, fraction);
    if (part.empty()) return part;
    // Also if it begins this very instant: a tick ago the clock was not there.
    part.low_open = is_strict && (part.low > now || before <= limit);
    part.high_open = is_strict && part.high != kForever;
    all.meet(part);
  }
  if (op == BoundOp::Eq || op == BoundOp::Le || op == BoundOp::Lt) {
    const bool is_strict = op == BoundOp::Lt;
    Interval part = interval::at_most(now, missing - (is_strict ? 1 : 0), speed, fraction);
    if (part.empty()) return part;
    part.low_open = is_strict && (part.low > now || before >= limit);
    part.high_open = is_strict && part.high != kForever;
    all.meet(part);
  }
  return all;
}

/// The same of a clock that runs at speed 1 and has its limit at the instant `at`, which is near.
[[nodiscard]] inline Interval instants_around(i64 now, i64 at, BoundOp op) {
  switch (op) {
    case BoundOp::Ge: return {std::max(now, at), kForever, false, false};
    case BoundOp::Gt: return {std::max(now, at + 1), kForever, now <= at + 1, false};
    case BoundOp::Le: return at < now ? Interval::none() : Interval{now, at, false, false};
    case BoundOp::Lt: return at <= now ? Interval::none() : Interval{now, at - 1, false, true};
    case BoundOp::Eq: break;
  }
  return at < now ? Interval::none() : Interval{at, at, false, false};
}

}  // namespace bip::rt
