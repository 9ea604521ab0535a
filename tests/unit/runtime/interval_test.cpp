// Instants of bounds against a count over every instant; the heap against a sorted list; times as text.
#include <catch2/catch.hpp>

#include <algorithm>
#include <map>

#include "runtime/include/bip/prng.hpp"
#include "runtime/core/time/time_heap.hpp"
#include "runtime/core/time/time_text.hpp"

using namespace bip::rt;

namespace {

bool compares(Int128 value, BoundOp op, i64 limit) {
  switch (op) {
    case BoundOp::Lt: return value < limit;
    case BoundOp::Le: return value <= limit;
    case BoundOp::Gt: return value > limit;
    case BoundOp::Ge: return value >= limit;
    case BoundOp::Eq: return value == limit;
  }
  return false;
}

// In 2^-32.
Int128 exactly(Int128 value) { return value << 32; }
Int128 after(Int128 exact, i64 speed, i64 ticks) { return exact + static_cast<Int128>(speed) * ticks; }

}  // namespace

TEST_CASE("a bound holds at the instants of its interval and at no other") {
  Prng random(7);
  int empty = 0, bounded = 0;
  for (int round = 0; round < 20'000; ++round) {
    const i64 now = static_cast<i64>(random.below(50));
    const i64 value = static_cast<i64>(random.below(41)) - 20;
    const i64 limit = static_cast<i64>(random.below(61)) - 30;
    // Speeds of differences may be negative; halves, thirds (rounded), and whole ones.
    const i64 speeds[] = {
        kUnitSpeed, 0, kUnitSpeed / 2, kUnitSpeed * 3, -kUnitSpeed, -kUnitSpeed / 2, kUnitSpeed / 3, -kUnitSpeed * 2};
    const i64 speed = speeds[random.below(8)];
    const auto op = static_cast<BoundOp>(random.below(5));
    const Int128 exact = exactly(value) + static_cast<i64>(random.below(3) == 0 ? 0 : random.below(u64{1} << 32));
    const Interval found = instants_of(now, exact, speed, op, limit);
    empty += found.empty() ? 1 : 0;
    bounded += !found.empty() && found.high != kForever ? 1 : 0;
    for (i64 t = now; t < now + 200; ++t) {
      const bool holds = compares(after(exact, speed, t - now) >> 32, op, limit);
      if (holds != found.has(t)) {
        FAIL("value " << value << " speed " << static_cast<double>(speed) / static_cast<double>(kUnitSpeed) << " op "
                      << static_cast<int>(op) << " limit " << limit << " now " << now << " t " << t << ": ["
                      << found.low << ", " << found.high << "]");
      }
    }
  }
  CHECK(empty > 1000);
  CHECK(bounded > 1000);
}

TEST_CASE("a bound has the same instants whenever it is looked at") {
  Prng random(9);
  int later = 0;
  for (int round = 0; round < 20'000; ++round) {
    const Int128 exact =
        exactly(static_cast<i64>(random.below(41)) - 20) + static_cast<i64>(random.below(u64{1} << 32));
    const i64 speed = static_cast<i64>(random.below(u64{1} << 34)) - (i64{1} << 33);
    const i64 limit = static_cast<i64>(random.below(61)) - 30, passed = static_cast<i64>(random.below(30));
    const auto op = static_cast<BoundOp>(random.below(5));
    const Interval first = instants_of(0, exact, speed, op, limit);
    const Interval second = instants_of(passed, after(exact, speed, passed), speed, op, limit);
    REQUIRE(second.empty() == (first.empty() || first.high < passed));
    if (second.empty()) continue;
    CHECK(second.low == std::max(first.low, passed));
    CHECK(second.high == first.high);
    if (first.low >= passed && first.low > 0) CHECK(second.low_open == first.low_open);
    later += first.low > passed ? 1 : 0;
  }
  CHECK(later > 1000);
}

TEST_CASE("a clock at speed 1 needs no division") {
  Prng random(8);
  for (int round = 0; round < 20'000; ++round) {
    const i64 now = static_cast<i64>(random.below(20)), value = static_cast<i64>(random.below(20)) - 5,
              limit = static_cast<i64>(random.below(40)) - 10;
    const auto op = static_cast<BoundOp>(random.below(5));
    const Interval one = instants_of(now, exactly(value), kUnitSpeed, op, limit),
                   other = instants_around(now, now + limit - value, op);
    REQUIRE(one.empty() == other.empty());
    if (one.empty()) continue;
    CHECK((one.low == other.low && one.high == other.high && one.low_open == other.low_open &&
           one.high_open == other.high_open));
  }
}

TEST_CASE("the ends of time are no instants") {
  CHECK(instants_of(0, 0, 1, BoundOp::Ge, kMaxTicks).empty());
  CHECK(instants_of(0, 0, 1, BoundOp::Le, kMaxTicks).high == kForever);
  CHECK(instants_of(kMaxTicks, exactly(kMaxTicks), kUnitSpeed, BoundOp::Ge, -kMaxTicks).low == kMaxTicks);
  CHECK(instants_of(5, 0, kUnitSpeed, BoundOp::Gt, 10).low_open);
  CHECK(instants_of(5, 0, kUnitSpeed, BoundOp::Gt, 10).low == 16);
}

TEST_CASE("a strict bound begins at an instant if it did not hold a tick ago") {
  for (const i64 speed : {i64{0}, kUnitSpeed, -kUnitSpeed, kUnitSpeed / 2}) {
    for (i64 limit = -8; limit <= 8; ++limit) {
      for (i64 value = -8; value <= 8; ++value) {
        for (i64 passed = 1; passed < 4; ++passed) {
          // The clock was set `passed` ticks ago.
          const Int128 before = after(exactly(value), speed, passed - 1) >> 32;
          for (const BoundOp op : {BoundOp::Gt, BoundOp::Lt}) {
            const Interval found = instants_of(passed, after(exactly(value), speed, passed), speed, op, limit);
            if (found.empty() || found.low != passed) continue;
            CHECK(found.low_open == !compares(before, op, limit));
          }
        }
      }
    }
  }
  // A difference that does not change began long ago, also one tick above its limit.
  CHECK_FALSE(instants_of(9, exactly(6), 0, BoundOp::Gt, 5).low_open);
  CHECK_FALSE(instants_of(9, exactly(4), 0, BoundOp::Lt, 5).low_open);
}

TEST_CASE("the heap knows the smallest key") {
  constexpr std::uint32_t kRows = 40;
  TimeHeap heap;
  heap.reset(kRows);
  std::map<std::uint32_t, i64> keys;
  Prng random(3);
  for (int round = 0; round < 20'000; ++round) {
    const auto row = static_cast<std::uint32_t>(random.below(kRows));
    const i64 key = random.below(4) == 0 ? kForever : static_cast<i64>(random.below(30));
    heap.set(row, key);
    if (key == kForever) keys.erase(row);
    else keys[row] = key;
    std::pair<i64, std::uint32_t> first{kForever, 0};
    for (const auto& [r, k] : keys) first = std::min(first, {k, r});
    REQUIRE(heap.first_key() == first.first);
    REQUIRE(heap.empty() == keys.empty());
    if (!keys.empty()) REQUIRE(heap.first_row() == first.second);
  }
}

TEST_CASE("times as text") {
  const auto text = [](i64 ticks) {
    std::string out;
    append_time(out, ticks);
    return out;
  };
  CHECK(text(0) == "0");
  CHECK(text(4'200'939) == "4ms200us939ns");
  CHECK(text(6'000'000'000) == "6s");
  CHECK(text(-1) == "-1ns");
  const auto shown = [](Interval interval) {
    std::string out;
    append_interval(out, interval);
    return out;
  };
  CHECK(shown({0, 5'000'000, false, false}) == "[ 0, 5ms ]");
  CHECK(shown({2'000'000'001, 2'999'999'999, true, true}) == "] 2s, 3s [");
  CHECK(shown({0, kForever, false, false}) == "[ 0, +INFTY [");
}
