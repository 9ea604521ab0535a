// What a clause's code can come to while its variables are only known to lie in ranges: interval arithmetic (Moore
// 1966) over the operations that the compiler wrote down (bip/image.hpp, RangeOp). Sound: the code's values lie in the
// ranges that come out.
//
// Bounds are doubles, exact for ints. An int range that arithmetic could make wrap, and a float range without bounds
// (which then includes NaN), say nothing. Cost: linear in the operations; of a branch that is not decided both sides.
#pragma once
#include <limits>
#include <vector>

#include "bip/image.hpp"

namespace bip::rt {

/// lo <= hi; a bool is 0 or 1.
struct Range {
  double lo = 0, hi = 0;
  [[nodiscard]] static Range of(double value) { return {value, value}; }
  /// Everything that the type has.
  [[nodiscard]] static Range all(CellType type) {
    if (type == CellType::Int)
      return {std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()};
    if (type == CellType::Bool) return {0, 1};
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  }
  [[nodiscard]] static Range of(CellType type, const Cell& cell);
  void join(const Range& other) {
    if (other.lo < lo) lo = other.lo;
    if (other.hi > hi) hi = other.hi;
  }
};

/// A bound variable: a cell whose value is known, or a range.
struct BoundRange {
  const Cell* cell = nullptr;
  Range range{};
};

class RangeMachine {
 public:
  /// Runs a body; own: the ranges of the connector's variables, size of them, changed.
  void run(Span<RangeOp> body, Range* own, std::size_t size, const BoundRange* bound);
  /// A guard's ranges: {0, 0} if it is false, whatever the values.
  [[nodiscard]] Range value(Span<RangeOp> guard, Range* own, const BoundRange* bound);

 private:
  void run(const RangeOp* op, const RangeOp* end, Range* own, std::size_t size, const BoundRange* bound);
  void unary(const RangeOp& op);
  void binary(const RangeOp& op);
  std::vector<Range> stack_;
};

}  // namespace bip::rt
