// See dbm.hpp.
#include "runtime/explore/dbm.hpp"

#include <algorithm>
#include <cstdlib>

#include "bip/assert.hpp"

namespace bip::rt {

namespace {

// Bounds stay below it, so that sums of a path do not overflow.
constexpr std::int64_t kLargest = std::int64_t{1} << 61;

std::int64_t sum(std::int64_t a, std::int64_t b) { return a == Zone::kInf || b == Zone::kInf ? Zone::kInf : a + b; }

}  // namespace

bool Zone::is_canonical() const {
  for (u32 k = 0; k < size_; ++k) {
    if (at(k, k) != 0) return false;
    for (u32 i = 0; i < size_; ++i) {
      for (u32 j = 0; j < size_; ++j) {
        if (at(i, j) > sum(at(i, k), at(k, j))) return false;
      }
    }
  }
  return true;
}

// Only paths through the new bound can be shorter than before.
bool Zone::meet(const ZoneBound& add) {
  BIP_ASSERT(add.i != add.j && add.i < size_ && add.j < size_, "a bound on clocks {} and {}", add.i, add.j);
  BIP_ASSERT(std::abs(add.limit) < kLargest, "limit {}", add.limit);
  if (implies(add)) return true;
  if (sum(at(add.j, add.i), add.limit) < 0) return false;
  bound(add.i, add.j) = add.limit;
  for (u32 i = 0; i < size_; ++i) {
    const i64 to = sum(at(i, add.i), add.limit);
    if (to == kInf) continue;
    for (u32 j = 0; j < size_; ++j) bound(i, j) = std::min(at(i, j), sum(to, at(add.j, j)));
  }
  BIP_ASSERT(is_canonical(), "after x{} - x{} <= {}", add.i, add.j, add.limit);
  return true;
}

bool Zone::meet(const Zone& other) {
  for (u32 i = 0; i < size_; ++i) {
    for (u32 j = 0; j < size_; ++j) {
      if (i != j && other.at(i, j) != kInf && !meet(ZoneBound{i, j, other.at(i, j)})) return false;
    }
  }
  return true;
}

void Zone::let_time_precede() {
  for (u32 i = 1; i < size_; ++i) bound(0, i) = kInf;
  BIP_ASSERT(is_canonical(), "before time passed");
}

void Zone::let_time_pass() {
  for (u32 i = 1; i < size_; ++i) bound(i, 0) = kInf;
  BIP_ASSERT(is_canonical(), "after time passed");
}

void Zone::shift(i64 ticks) {
  for (u32 i = 1; i < size_; ++i) {
    bound(i, 0) = sum(at(i, 0), ticks);
    bound(0, i) -= ticks;
  }
  BIP_ASSERT(is_canonical(), "after {} ticks", ticks);
}

void Zone::set_clock(u32 clock, i64 value) {
  BIP_ASSERT(clock != 0 && clock < size_, "clock {} of {}", clock, size_);
  for (u32 k = 0; k < size_; ++k) {
    if (k == clock) continue;
    bound(clock, k) = sum(value, at(0, k));
    bound(k, clock) = sum(at(k, 0), -value);
  }
  BIP_ASSERT(is_canonical(), "after clock {} became {}", clock, value);
}

void Zone::forget_clock(u32 clock) {
  BIP_ASSERT(clock != 0 && clock < size_, "clock {} of {}", clock, size_);
  for (u32 k = 0; k < size_; ++k) {
    if (k == clock) continue;
    bound(clock, k) = kInf;
    bound(k, clock) = at(k, 0);
  }
  BIP_ASSERT(is_canonical(), "after clock {} was forgotten", clock);
}

void Zone::free_clock(u32 clock) {
  BIP_ASSERT(clock != 0 && clock < size_, "clock {} of {}", clock, size_);
  for (u32 k = 0; k < size_; ++k) {
    if (k != clock) bound(clock, k) = bound(k, clock) = kInf;
  }
  BIP_ASSERT(is_canonical(), "after clock {} became free", clock);
}

bool Zone::includes(const std::vector<i64>& point) const {
  BIP_ASSERT(point.size() == size_, "{} clock values for a zone of {}", point.size(), size_);
  for (u32 i = 0; i < size_; ++i) {
    for (u32 j = 0; j < size_; ++j) {
      if (at(i, j) != kInf && point[i] - point[j] > at(i, j)) return false;
    }
  }
  return true;
}

bool Zone::includes(const Zone& other) const {
  BIP_ASSERT(size_ == other.size_, "zones of {} and {} clocks", size_, other.size_);
  return std::equal(bounds_.begin(), bounds_.end(), other.bounds_.begin(),
                    [](i64 mine, i64 its) { return its <= mine; });
}

std::vector<Zone::i64> Zone::least_point() const {
  std::vector<i64> point(size_, 0);
  for (u32 i = 1; i < size_; ++i) point[i] = -at(0, i);
  return point;
}

bool Zone::is_unbounded() const {
  for (u32 i = 1; i < size_; ++i) {
    if (at(i, 0) != kInf) return false;
  }
  return true;
}

void Zone::close() {
  for (u32 k = 0; k < size_; ++k) {
    for (u32 i = 0; i < size_; ++i) {
      const i64 to = at(i, k);
      if (to == kInf) continue;
      for (u32 j = 0; j < size_; ++j) bound(i, j) = std::min(at(i, j), sum(to, at(k, j)));
    }
  }
}

void Zone::extrapolate(const std::vector<i64>& max, const std::vector<i64>& min) {
  BIP_ASSERT(max.size() == size_ && min.size() == size_, "{} and {} constants", max.size(), min.size());
#ifdef BIP_CHECKED
  const Zone before = *this;
#endif
  bool is_changed = false;
  const std::vector<i64> least = least_point();
  const auto widen = [&](u32 i, u32 j, i64 limit) {
    if (at(i, j) == limit) return;
    bound(i, j) = limit;
    is_changed = true;
  };
  for (u32 i = 1; i < size_; ++i) {
    for (u32 j = 0; j < size_; ++j) {
      if (i != j && (at(i, j) > max[i] - min[j] || least[i] > max[i] || (j != 0 && least[j] > max[j])))
        widen(i, j, kInf);
    }
    if (least[i] > max[i]) widen(0, i, -(max[i] + 1));
  }
  if (is_changed) close();
  BIP_ASSERT(is_canonical(), "after extrapolation");
#ifdef BIP_CHECKED
  BIP_ASSERT(includes(before), "extrapolation lost points");
#endif
}

void subtract(const Zone& zone, const Zone& hole, std::vector<Zone>& out) {
  BIP_ASSERT(zone.size() == hole.size(), "zones of {} and {} clocks", zone.size(), hole.size());
  Zone rest = zone;
  Zone common = zone;
  for (Zone::u32 i = 0; i < zone.size(); ++i) {
    for (Zone::u32 j = 0; j < zone.size(); ++j) {
      if (i != j && hole.at(i, j) != Zone::kInf && !common.meet({i, j, hole.at(i, j)})) {
        out.push_back(zone);
        return;
      }
    }
  }
  for (Zone::u32 i = 0; i < zone.size(); ++i) {
    for (Zone::u32 j = 0; j < zone.size(); ++j) {
      if (i == j || hole.at(i, j) == Zone::kInf || rest.implies({i, j, hole.at(i, j)})) continue;
      const ZoneBound inside{i, j, hole.at(i, j)};
      Zone part = rest;
      if (part.meet(inside.opposite())) {
        BIP_ASSERT(zone.includes(part) && !part.implies(inside), "a piece that meets the hole");
        out.push_back(std::move(part));
      }
      if (!rest.meet(inside)) return;
    }
  }
}

}  // namespace bip::rt
