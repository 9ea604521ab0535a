// The abstract domain of intervals: what guards and actions do to ranges of variables. Bools count as 0 and 1, strings
// as their rows; ranges of floats and FFI values have no meaning.
//
// P. Cousot, R. Cousot: Static Determination of Dynamic Properties of Programs (1976).
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "compiler/model/abstract_interpreter.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

struct Range {
  std::int64_t low = 0, high = 0;
  [[nodiscard]] bool is_empty() const { return low > high; }
  friend bool operator==(const Range&, const Range&) = default;
};
inline constexpr Range kAnyInt{std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()};
inline constexpr Range kAnyBool{0, 1};

/// Returns the smallest range that has both in it.
[[nodiscard]] inline Range joined(const Range& a, const Range& b) {
  if (a.is_empty()) return b;
  if (b.is_empty()) return a;
  return {std::min(a.low, b.low), std::max(a.high, b.high)};
}
/// Returns what both have in common; it may be empty.
[[nodiscard]] inline Range common(const Range& a, const Range& b) {
  return {std::max(a.low, b.low), std::min(a.high, b.high)};
}
/// Returns the range itself, or any int if an int may wrap.
[[nodiscard]] inline Range fitted(const Range& r) { return r.low < kAnyInt.low || r.high > kAnyInt.high ? kAnyInt : r; }
[[nodiscard]] inline Range truth_range(bool may_be_false, bool may_be_true) {
  return {may_be_false ? 0 : 1, may_be_true ? 1 : 0};
}

/// The abstract state of a piece of code: copies of its variables' ranges, which guards refine.
struct IntervalPoint {
  std::vector<Range> self, bind;
};

/// The domain of intervals.
class IntervalDomain : public AbstractInterpreter<IntervalDomain, Range, IntervalPoint> {
 public:
  using AbstractInterpreter::AbstractInterpreter;

  Range constant(const Expr& e) { return e.op == Op::ConstFloat ? kAnyInt : Range{e.int_value, e.int_value}; }
  Range load(const Expr& e, IntervalPoint& local) {
    const std::vector<Range>& ranges = e.op == Op::LoadSelf ? local.self : local.bind;
    return e.index < ranges.size() ? ranges[e.index] : whole(e.type);
  }
  Range call(const Expr& e, IntervalPoint& local) {
    pass_arguments(e, local);
    return whole(e.type);
  }
  void forget(const Expr& load, IntervalPoint& local) {
    (load.op == Op::LoadSelf ? local.self : local.bind)[load.index] = kAnyInt;
  }
  Range unary(const Expr& e, const Range& a, IntervalPoint&) {
    if (e.type == Type::Float || a.is_empty()) return whole(e.type);
    switch (e.op) {
      case Op::Neg: return fitted({-a.high, -a.low});
      case Op::BitNot: return {-1 - a.high, -1 - a.low};
      case Op::Not:
        return {1 - a.high, 1 - a.low};
        BIP_LEAF_OPS(BIP_OP_CASE)
        BIP_CONVERSION_OPS(BIP_OP_CASE)
        BIP_BINARY_OPS(BIP_OP_CASE)
        break;
    }
    return whole(e.type);
  }
  Range binary(const Expr& e, const Range& a, const Range& b, IntervalPoint&) {
    if (!is_int(e) || a.is_empty() || b.is_empty()) return whole(e.type);
    return apply(e.op, a, b);
  }
  // Whether the second operand is evaluated makes no difference to the ranges.
  Range logic(const Expr& e, IntervalPoint& local) {
    const Range a = evaluate(e.a, local), b = evaluate(e.b, local);
    return binary(e, a, b, local);
  }

  /// Refines the variables to the states in which the condition is `truth`; false: there is none.
  bool assume(ExprId id, bool truth, IntervalPoint& local) {
    if (!id.is_valid()) return truth;
    const Expr& e = code_.exprs[id];
    if (e.op == Op::Not) return assume(e.a, !truth, local);
    if ((e.op == Op::And && truth) || (e.op == Op::Or && !truth))
      return assume(e.a, truth, local) && assume(e.b, truth, local);
    if (e.op == Op::And || e.op == Op::Or) {
      IntervalPoint other = local;
      const bool first = assume(e.a, truth, local);
      const bool second = assume(e.b, truth, other);
      if (!first) local = std::move(other);
      else if (second) join(local, other);
      return first || second;
    }
    if (is_load(e.op)) return narrow(id, {truth ? 1 : 0, truth ? 1 : 0}, local);
    if (is_comparison(e.op)) return !is_int(e) || compare(truth ? e.op : negation_of(e.op), e.a, e.b, local);
    const Range r = evaluate(id, local);
    return r.is_empty() || common(r, truth_range(!truth, truth)).low <= common(r, truth_range(!truth, truth)).high;
  }

  bool goes_on(const IntervalPoint&) { return true; }
  void store(const Stmt& s, IntervalPoint& local) {
    const Range value = evaluate(s.value, local);
    (s.op == StmtOp::StoreSelf ? local.self : local.bind)[s.index] = value;
  }
  void branch(const Stmt& s, IntervalPoint& local) {
    IntervalPoint other = local;
    (void)evaluate(s.value, local);
    const bool yes = assume(s.value, true, local);
    const bool no = assume(s.value, false, other);
    if (yes) execute(s.then_body, local);
    if (no) execute(s.else_body, other);
    if (!yes) local = std::move(other);
    else if (no) join(local, other);
  }
  void run_call(const Stmt& s, IntervalPoint& local) { (void)evaluate(s.value, local); }

  /// The operator on two ints, of which neither range is empty.
  static Range apply(Op op, const Range& a, const Range& b) {
    switch (op) {
      case Op::Add: return fitted({a.low + b.low, a.high + b.high});
      case Op::Sub: return fitted({a.low - b.high, a.high - b.low});
      case Op::Mul: {
        const auto [low, high] = std::minmax({a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high});
        return fitted({low, high});
      }
      case Op::Div: {
        // The quotient is nearest to zero for the largest divisor, farthest for one near zero.
        const std::int64_t most = std::max(std::abs(a.low), std::abs(a.high));
        const std::int64_t least = b.low > 0 ? b.low : b.high < 0 ? -b.high : 1;
        const bool same_sign = a.low >= 0 && b.low >= 0;
        return fitted({same_sign ? 0 : -(most / least), most / least});
      }
      case Op::Mod: {
        // Within one turn of a constant divisor.
        if (b.low == b.high && b.low > 0 && a.low >= 0 && a.low / b.low == a.high / b.low)
          return {a.low % b.low, a.high % b.low};
        const std::int64_t most =
            std::min(std::max(std::abs(b.low), std::abs(b.high)) - 1, std::max(std::abs(a.low), std::abs(a.high)));
        return fitted(
            {a.low >= 0 ? 0 : -std::max<std::int64_t>(most, 0), a.high <= 0 ? 0 : std::max<std::int64_t>(most, 0)});
      }
      case Op::BitAnd:
        if (a.low >= 0 || b.low >= 0) return {0, a.low < 0 ? b.high : b.low < 0 ? a.high : std::min(a.high, b.high)};
        return kAnyInt;
      case Op::BitOr:
      case Op::BitXor: {
        if (a.low < 0 || b.low < 0) return kAnyInt;
        std::int64_t mask = 1;
        while (mask <= std::max(a.high, b.high)) mask *= 2;
        return {0, mask - 1};
      }
      case Op::And: return {std::min(a.low, b.low), std::min(a.high, b.high)};
      case Op::Or: return {std::max(a.low, b.low), std::max(a.high, b.high)};
      case Op::Eq: return truth_range(a.low != a.high || a != b, !common(a, b).is_empty());
      case Op::Ne: return truth_range(!common(a, b).is_empty(), a.low != a.high || a != b);
      case Op::Lt: return truth_range(a.high >= b.low, a.low < b.high);
      case Op::Le: return truth_range(a.high > b.low, a.low <= b.high);
      case Op::Gt: return truth_range(b.high >= a.low, b.low < a.high);
      case Op::Ge:
        return truth_range(b.high > a.low, b.low <= a.high);
        BIP_LEAF_OPS(BIP_OP_CASE)
        BIP_UNARY_OPS(BIP_OP_CASE)
        break;
    }
    BIP_UNREACHABLE("not an operator of two ints");
  }

 private:
  static void join(IntervalPoint& to, const IntervalPoint& from) {
    for (std::size_t k = 0; k < to.self.size(); ++k) to.self[k] = joined(to.self[k], from.self[k]);
    for (std::size_t k = 0; k < to.bind.size(); ++k) to.bind[k] = joined(to.bind[k], from.bind[k]);
  }
  static Range whole(Type type) { return type == Type::Bool ? kAnyBool : kAnyInt; }
  // The operands are ints, bools or rows of strings.
  bool is_int(const Expr& e) const {
    const Type operands = code_.exprs[e.a].type;
    return operands != Type::Float && !is_ffi(operands);
  }
  bool narrow(ExprId id, const Range& to, IntervalPoint& local) {
    const Expr& e = code_.exprs[id];
    if (!is_load(e.op)) return true;
    std::vector<Range>& all = e.op == Op::LoadSelf ? local.self : local.bind;
    if (e.index >= all.size() || all[e.index].is_empty()) return true;
    all[e.index] = common(all[e.index], to);
    return !all[e.index].is_empty();
  }
  bool compare(Op op, ExprId left, ExprId right, IntervalPoint& local) {
    const Range a = evaluate(left, local), b = evaluate(right, local);
    if (a.is_empty() || b.is_empty()) return true;
    constexpr std::int64_t kFar = std::int64_t{1} << 40;
    switch (op) {
      case Op::Eq: return narrow(left, b, local) && narrow(right, a, local) && !common(a, b).is_empty();
      case Op::Lt:
        return a.low < b.high && narrow(left, {-kFar, b.high - 1}, local) && narrow(right, {a.low + 1, kFar}, local);
      case Op::Le:
        return a.low <= b.high && narrow(left, {-kFar, b.high}, local) && narrow(right, {a.low, kFar}, local);
      case Op::Gt:
        return b.low < a.high && narrow(left, {b.low + 1, kFar}, local) && narrow(right, {-kFar, a.high - 1}, local);
      case Op::Ge:
        return b.low <= a.high && narrow(left, {b.low, kFar}, local) && narrow(right, {-kFar, a.high}, local);
      case Op::Ne:
        break;
        BIP_NO_COMPARISON_OPS(BIP_OP_CASE)
        BIP_UNREACHABLE("not a comparison");
    }
    // !=: only an end can be cut off.
    const auto without = [](const Range& r, const Range& x) {
      if (x.low != x.high) return r;
      return Range{r.low == x.low ? r.low + 1 : r.low, r.high == x.low ? r.high - 1 : r.high};
    };
    return narrow(left, without(a, b), local) && narrow(right, without(b, a), local) && !(a == b && a.low == a.high);
  }
};

}  // namespace bip::verify
