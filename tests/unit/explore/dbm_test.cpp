// Zones against sets of points: every operation on random zones, enumerated.
#include <catch2/catch.hpp>

#include <set>

#include "runtime/include/bip/prng.hpp"
#include "runtime/explore/dbm.hpp"

using namespace bip::rt;
using i64 = std::int64_t;
using u32 = std::uint32_t;

namespace {

constexpr i64 kEnd = 9;  // points have coordinates in [0, kEnd]
using Points = std::set<std::pair<i64, i64>>;

bool has(const Zone& zone, i64 x, i64 y) {
  const i64 value[] = {0, x, y};
  for (u32 i = 0; i < 3; ++i) {
    for (u32 j = 0; j < 3; ++j) {
      if (zone.at(i, j) != Zone::kInf && value[i] - value[j] > zone.at(i, j)) return false;
    }
  }
  return true;
}

Points points_of(const Zone& zone) {
  Points points;
  for (i64 x = 0; x <= kEnd; ++x) {
    for (i64 y = 0; y <= kEnd; ++y) {
      if (has(zone, x, y)) points.insert({x, y});
    }
  }
  return points;
}

ZoneBound random_bound(Prng& random) {
  const u32 i = static_cast<u32>(random.below(3));
  u32 j = static_cast<u32>(random.below(2));
  j += j >= i ? 1 : 0;
  const i64 limit = static_cast<i64>(random.below(11)) - 5;
  return {i, j, j == 0 ? std::max<i64>(limit, 0) : i == 0 ? std::min<i64>(limit, 0) : limit};
}

// Not empty, somewhere in the square.
Zone random_zone(Prng& random) {
  for (;;) {
    Zone zone(2);
    zone.let_time_pass();
    zone.set_clock(1 + static_cast<u32>(random.below(2)), static_cast<i64>(random.below(5)));
    zone.let_time_pass();
    bool is_sound = zone.meet({1, 0, kEnd}) && zone.meet({2, 0, kEnd});
    for (std::uint64_t k = random.below(4); is_sound && k-- > 0;) is_sound = zone.meet(random_bound(random));
    if (is_sound) return zone;
  }
}

}  // namespace

TEST_CASE("operations on zones are those on their points") {
  Prng random(7);
  for (int round = 0; round < 3000; ++round) {
    const Zone zone = random_zone(random);
    const Points points = points_of(zone);
    REQUIRE_FALSE(points.empty());
    const std::vector<i64> least = zone.least_point();
    REQUIRE(has(zone, least[1], least[2]));

    const ZoneBound bound = random_bound(random);
    Zone inside = zone, outside = zone;
    const bool is_inside = inside.meet(bound), is_outside = outside.meet(bound.opposite());
    REQUIRE((is_inside && is_outside) == zone.is_cut_by(bound));
    REQUIRE(zone.implies(bound) == !is_outside);
    Points both;
    if (is_inside) both = points_of(inside);
    if (is_outside)
      for (const auto& point : points_of(outside)) REQUIRE(both.insert(point).second);
    REQUIRE(both == points);

    Zone later = zone;
    later.let_time_pass();
    Points delayed;
    for (const auto& [x, y] : points) {
      for (i64 d = 0; x + d <= kEnd && y + d <= kEnd; ++d) delayed.insert({x + d, y + d});
    }
    REQUIRE(points_of(later) == delayed);

    Zone set = zone;
    set.set_clock(1, 3);
    Points moved;
    for (const auto& point : points) moved.insert({3, point.second});
    REQUIRE(points_of(set) == moved);

    Zone forgotten = zone;
    forgotten.forget_clock(1);
    Points any;
    for (const auto& point : points) {
      for (i64 x = 0; x <= kEnd; ++x) any.insert({x, point.second});
    }
    REQUIRE(points_of(forgotten) == any);

    const Zone other = random_zone(random);
    const Points others = points_of(other);
    REQUIRE(zone.includes(other) == std::includes(points.begin(), points.end(), others.begin(), others.end()));
    std::vector<Zone> parts;
    subtract(zone, other, parts);
    Points rest;
    for (const Zone& part : parts) {
      for (const auto& point : points_of(part)) REQUIRE(rest.insert(point).second);
    }
    Points expected;
    std::set_difference(points.begin(), points.end(), others.begin(), others.end(),
                        std::inserter(expected, expected.end()));
    REQUIRE(rest == expected);
  }
}

// Every point that extrapolation adds agrees with one that was there about all comparisons, now and after any time.
TEST_CASE("extrapolation only adds points that no comparison tells from old ones") {
  Prng random(11);
  for (int round = 0; round < 2000; ++round) {
    const Zone zone = random_zone(random);
    const std::vector<i64> max{0, static_cast<i64>(random.below(4)), static_cast<i64>(random.below(4))}, min(3, 0);
    Zone wide = zone;
    wide.extrapolate(max, min);
    REQUIRE(wide.includes(zone));
    const auto seen = [&](i64 x, i64 y) {
      // What comparisons with constants up to max see of a point's future.
      std::vector<std::pair<i64, i64>> out;
      for (i64 d = 0; d <= 4; ++d) out.push_back({std::min(x + d, max[1] + 1), std::min(y + d, max[2] + 1)});
      return out;
    };
    std::set<std::vector<std::pair<i64, i64>>> old;
    for (const auto& [x, y] : points_of(zone)) old.insert(seen(x, y));
    for (const auto& [x, y] : points_of(wide)) REQUIRE(old.count(seen(x, y)) == 1);
  }
}
