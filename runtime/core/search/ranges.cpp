// See ranges.hpp.
#include "runtime/core/search/ranges.hpp"

#include <algorithm>
#include <cmath>

#include "bip/assert.hpp"

namespace bip::rt {

namespace {

bool is_unbounded(const Range& range) { return std::isinf(range.lo) || std::isinf(range.hi); }

// What arithmetic gave, if the type has all of it.
Range fitting(CellType type, const Range& range) {
  const Range all = Range::all(type);
  // Not (inside), for NaN is not inside either.
  return range.lo >= all.lo && range.hi <= all.hi && !is_unbounded(range) ? range : all;
}
Range truth(bool can_be_false, bool can_be_true) { return {can_be_false ? 0.0 : 1.0, can_be_true ? 1.0 : 0.0}; }

Range product(const Range& a, const Range& b) {
  const auto [lo, hi] = std::minmax({a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi});
  return {lo, hi};
}

// Comparisons with what may be NaN or infinite are not decided.
Range compared(RangeOpKind kind, const Range& a, const Range& b) {
  if (is_unbounded(a) || is_unbounded(b)) return {0, 1};
  const bool may_meet = a.lo <= b.hi && b.lo <= a.hi, is_same = a.lo == a.hi && b.lo == b.hi && a.lo == b.lo;
  switch (kind) {
    case RangeOpKind::Eq: return truth(!is_same, may_meet);
    case RangeOpKind::Ne: return truth(may_meet, !is_same);
    case RangeOpKind::Lt: return truth(a.hi >= b.lo, a.lo < b.hi);
    case RangeOpKind::Le: return truth(a.hi > b.lo, a.lo <= b.hi);
    case RangeOpKind::Constant:
    case RangeOpKind::Any:
    case RangeOpKind::Own:
    case RangeOpKind::Bound:
    case RangeOpKind::Neg:
    case RangeOpKind::Add:
    case RangeOpKind::Sub:
    case RangeOpKind::Mul:
    case RangeOpKind::Not:
    case RangeOpKind::And:
    case RangeOpKind::Or:
    case RangeOpKind::Store:
    case RangeOpKind::Branch: break;
  }
  BIP_UNREACHABLE("not a comparison");
}

}  // namespace

Range Range::of(CellType type, const Cell& cell) {
  if (type == CellType::Int || type == CellType::Bool) return of(static_cast<double>(cell.i));
  if (type == CellType::Float && std::isfinite(cell.f)) return of(cell.f);
  return all(type);
}

void RangeMachine::unary(const RangeOp& op) {
  BIP_ASSERT(!stack_.empty(), "no operand");
  Range& a = stack_.back();
  a = op.kind == RangeOpKind::Not ? Range{1 - a.hi, 1 - a.lo} : fitting(op.type, {-a.hi, -a.lo});
}

void RangeMachine::binary(const RangeOp& op) {
  BIP_ASSERT(stack_.size() >= 2, "{} operands", stack_.size());
  const Range b = stack_.back();
  stack_.pop_back();
  Range& a = stack_.back();
  switch (op.kind) {
    case RangeOpKind::Add: a = fitting(op.type, {a.lo + b.lo, a.hi + b.hi}); break;
    case RangeOpKind::Sub: a = fitting(op.type, {a.lo - b.hi, a.hi - b.lo}); break;
    case RangeOpKind::Mul:
      a = is_unbounded(a) || is_unbounded(b) ? Range::all(op.type) : fitting(op.type, product(a, b));
      break;
    case RangeOpKind::And: a = {std::min(a.lo, b.lo), std::min(a.hi, b.hi)}; break;
    case RangeOpKind::Or: a = {std::max(a.lo, b.lo), std::max(a.hi, b.hi)}; break;
    case RangeOpKind::Eq:
    case RangeOpKind::Ne:
    case RangeOpKind::Lt:
    case RangeOpKind::Le: a = compared(op.kind, a, b); break;
    case RangeOpKind::Constant:
    case RangeOpKind::Any:
    case RangeOpKind::Own:
    case RangeOpKind::Bound:
    case RangeOpKind::Neg:
    case RangeOpKind::Not:
    case RangeOpKind::Store:
    case RangeOpKind::Branch: BIP_UNREACHABLE("not an operator of two ranges");
  }
}

void RangeMachine::run(const RangeOp* op, const RangeOp* end, Range* own, std::size_t size, const BoundRange* bound) {
  while (op != end) {
    const RangeOp& now = *op++;
    switch (now.kind) {
      case RangeOpKind::Constant:
        stack_.push_back(std::isfinite(now.number) ? Range::of(now.number) : Range::all(now.type));
        break;
      case RangeOpKind::Any: stack_.push_back(Range::all(now.type)); break;
      case RangeOpKind::Own: stack_.push_back(own[now.row]); break;
      case RangeOpKind::Bound: {
        const BoundRange& from = bound[now.row];
        stack_.push_back(from.cell != nullptr ? Range::of(now.type, *from.cell) : from.range);
        break;
      }
      case RangeOpKind::Neg:
      case RangeOpKind::Not: unary(now); break;
      case RangeOpKind::Store:
        BIP_ASSERT(!stack_.empty() && (size == 0 || now.row < size), "variable {} of {}", now.row, size);
        own[now.row] = stack_.back();
        stack_.pop_back();
        break;
      case RangeOpKind::Branch: {
        const Range condition = stack_.back();
        stack_.pop_back();
        const RangeOp* const middle = op + now.row;
        const RangeOp* const after = middle + now.otherwise;
        if (condition.lo > 0) {
          run(op, middle, own, size, bound);
        } else if (condition.hi <= 0) {
          run(middle, after, own, size, bound);
        } else {
          std::vector<Range> other(own, own + size);
          run(op, middle, own, size, bound);
          run(middle, after, other.data(), size, bound);
          for (std::size_t i = 0; i < size; ++i) own[i].join(other[i]);
        }
        op = after;
        break;
      }
      case RangeOpKind::Add:
      case RangeOpKind::Sub:
      case RangeOpKind::Mul:
      case RangeOpKind::And:
      case RangeOpKind::Or:
      case RangeOpKind::Eq:
      case RangeOpKind::Ne:
      case RangeOpKind::Lt:
      case RangeOpKind::Le: binary(now); break;
    }
  }
}

void RangeMachine::run(Span<RangeOp> body, Range* own, std::size_t size, const BoundRange* bound) {
  run(body.begin(), body.end(), own, size, bound);
  BIP_ASSERT(stack_.empty(), "a body left {} values", stack_.size());
}

Range RangeMachine::value(Span<RangeOp> guard, Range* own, const BoundRange* bound) {
  if (guard.size == 0) return Range::of(1);
  run(guard.begin(), guard.end(), own, 0, bound);
  BIP_ASSERT(stack_.size() == 1, "a guard left {} values", stack_.size());
  const Range result = stack_.back();
  stack_.pop_back();
  return result;
}

}  // namespace bip::rt
