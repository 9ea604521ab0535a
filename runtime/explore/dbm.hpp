// Zones: sets of clock values given by bounds on clocks and on their differences (difference bound matrices: Dill
// 1989).
//
// Clocks count whole ticks, so a zone is a set of integer points, every bound belongs to it, and all operations here
// are exact: a matrix that shortest paths have closed has an integer point on each of its bounds. Row and column 0
// stand for the value 0. A zone that an operation returned is closed and not empty unless it says so. Bounds stay below
// 2^61 in size.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bip/assert.hpp"
#include "runtime/explore/heap_bytes.hpp"

namespace bip::rt {

/// x_i - x_j <= limit
struct ZoneBound {
  std::uint32_t i = 0, j = 0;
  std::int64_t limit = 0;

  /// What holds where this does not.
  [[nodiscard]] ZoneBound opposite() const { return {j, i, -limit - 1}; }
  friend auto operator<=>(const ZoneBound&, const ZoneBound&) = default;
};

class Zone {
 public:
  using u32 = std::uint32_t;
  using i64 = std::int64_t;
  static constexpr i64 kInf = INT64_MAX;

  /// All clocks 0.
  explicit Zone(u32 clocks) : size_(clocks + 1), bounds_(std::size_t{size_} * size_, 0) {}

  [[nodiscard]] u32 size() const { return size_; }
  /// x_i - x_j <= at(i, j)
  [[nodiscard]] i64 at(u32 i, u32 j) const {
    BIP_ASSERT(i < size_ && j < size_, "clocks {} and {} of {}", i, j, size_);
    return bounds_[std::size_t{i} * size_ + j];
  }
  [[nodiscard]] std::size_t bytes() const { return heap_bytes(bounds_); }

  /// Only the points of which the bound holds. False: there are none, and the zone is no longer one. O(clocks^2).
  [[nodiscard]] bool meet(const ZoneBound& bound);
  /// The points of both; as above. O(clocks^4).
  [[nodiscard]] bool meet(const Zone& other);
  /// Has it points of which the bound holds, and others?
  [[nodiscard]] bool is_cut_by(const ZoneBound& bound) const {
    return at(bound.i, bound.j) > bound.limit && (at(bound.j, bound.i) == kInf || at(bound.j, bound.i) >= -bound.limit);
  }
  /// Do all its points satisfy the bound?
  [[nodiscard]] bool implies(const ZoneBound& bound) const { return at(bound.i, bound.j) <= bound.limit; }
  /// And all that time makes of them.
  void let_time_pass();
  /// And all from which time leads to them. There is no least point until a bound gives each clock one.
  void let_time_precede();
  /// Every clock `ticks` further.
  void shift(i64 ticks);
  void set_clock(u32 clock, i64 value);
  /// The clock may be anything from 0 on.
  void forget_clock(u32 clock);
  /// The clock may be anything; as let_time_precede.
  void free_clock(u32 clock);
  [[nodiscard]] bool includes(const Zone& other) const;
  /// [0] of the point is 0.
  [[nodiscard]] bool includes(const std::vector<i64>& point) const;
  /// A point: the least value of each clock; [0] is 0.
  [[nodiscard]] std::vector<i64> least_point() const;
  /// Can every clock be as large as one likes?
  [[nodiscard]] bool is_unbounded() const;

  /// Forgets what no comparison can see (Behrmann, Bouyer, Larsen, Pelanek 2006: Extra_M+): each clock is compared with
  /// nothing above max and never set below min. Exact for models without differences of clocks in conditions. [0] is 0.
  void extrapolate(const std::vector<i64>& max, const std::vector<i64>& min);

  /// Is the matrix closed under shortest paths, with 0 on its diagonal? O(clocks^3); for assertions.
  [[nodiscard]] bool is_canonical() const;

  friend bool operator==(const Zone&, const Zone&) = default;

 private:
  i64& bound(u32 i, u32 j) { return bounds_[std::size_t{i} * size_ + j]; }
  void close();

  u32 size_;
  std::vector<i64> bounds_;
};

/// The points of `zone` outside `hole`, as zones that do not meet.
void subtract(const Zone& zone, const Zone& hole, std::vector<Zone>& out);

}  // namespace bip::rt
