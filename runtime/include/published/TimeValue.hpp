// Instants and durations in the form of the published engine, as nanoseconds of model time.
#pragma once
#include <compare>
#include <cstdint>
#include <limits>

enum TimeUnit { NANOSECOND, MICROSECOND, MILLISECOND, SECOND, MINUTE, HOUR, DAY };

class TimeValue {
 public:
  TimeValue() = default;
  /// A value too large for 64 bits of nanoseconds is the largest one.
  TimeValue(std::int64_t value, TimeUnit unit) {
    if (__builtin_mul_overflow(value, nanoseconds_of(unit), &nanoseconds_)) {
      nanoseconds_ = value < 0 ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
    }
  }
  [[nodiscard]] static TimeValue zero() { return {}; }

  explicit operator std::int64_t() const { return nanoseconds_; }
  friend auto operator<=>(const TimeValue&, const TimeValue&) = default;
  TimeValue& operator+=(const TimeValue& more) {
    nanoseconds_ += more.nanoseconds_;
    return *this;
  }
  TimeValue& operator-=(const TimeValue& less) {
    nanoseconds_ -= less.nanoseconds_;
    return *this;
  }
  friend TimeValue operator+(TimeValue a, const TimeValue& b) { return a += b; }
  friend TimeValue operator-(TimeValue a, const TimeValue& b) { return a -= b; }

 private:
  static std::int64_t nanoseconds_of(TimeUnit unit) {
    switch (unit) {
      case NANOSECOND: return 1;
      case MICROSECOND: return 1'000;
      case MILLISECOND: return 1'000'000;
      case SECOND: return 1'000'000'000;
      case MINUTE: return 60'000'000'000;
      case HOUR: return 3'600'000'000'000;
      case DAY: return 86'400'000'000'000;
    }
    return 1;
  }

  std::int64_t nanoseconds_ = 0;
};
