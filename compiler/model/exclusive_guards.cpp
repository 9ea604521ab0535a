// See exclusive_guards.hpp. A guard becomes a list of alternatives (its disjunctive normal form, as far as that is
// small), each a list of comparisons; two guards exclude each other if each pair of alternatives has two comparisons
// that no values satisfy.
#include "compiler/model/exclusive_guards.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "compiler/model/operators.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip {

namespace {

constexpr std::size_t kMostAlternatives = 16;

// How two values compare, as bits. Unordered: one of them is no number.
constexpr unsigned kLess = 1, kEqual = 2, kGreater = 4, kUnordered = 8;

unsigned relations_of(Op op) {
  if (op == Op::Lt) return kLess;
  if (op == Op::Le) return kLess | kEqual;
  if (op == Op::Gt) return kGreater;
  if (op == Op::Ge) return kGreater | kEqual;
  if (op == Op::Eq) return kEqual;
  BIP_ASSERT(op == Op::Ne, "{} compares nothing", name_of(op));
  return kLess | kGreater | kUnordered;
}
/// The relations with the operands the other way round.
unsigned mirrored(unsigned relations) {
  return (relations & (kEqual | kUnordered)) | ((relations & kLess) != 0 ? kGreater : 0U) |
         ((relations & kGreater) != 0 ? kLess : 0U);
}

/// `left` and `right` compare in one of these ways. A condition that is no comparison is itself compared with true.
struct Comparison {
  ExprId left, right;  // right: invalid for true
  unsigned relations = 0;
};
using Alternative = std::vector<Comparison>;
using Alternatives = std::vector<Alternative>;

class GuardReader {
 public:
  explicit GuardReader(const CodeTable& code) : code_(code) {}

  /// Nothing: there are too many alternatives.
  std::optional<Alternatives> read(ExprId id, bool is_negated) const {
    const Expr& e = code_.exprs[id];
    if (e.op == Op::Not) return read(e.a, !is_negated);
    if (e.op == Op::And || e.op == Op::Or) {
      const std::optional<Alternatives> left = read(e.a, is_negated), right = read(e.b, is_negated);
      if (!left || !right) return std::nullopt;
      return (e.op == Op::And) != is_negated ? both(*left, *right) : either(*left, *right);
    }
    if (e.op == Op::ConstBool) {
      if ((e.int_value != 0) != is_negated) return Alternatives{{}};
      return Alternatives{};
    }
    if (!is_comparison(e.op)) return Alternatives{{{id, ExprId{}, is_negated ? kLess : kEqual}}};
    const bool is_float = code_.exprs[e.a].type == Type::Float;
    const unsigned all = kLess | kEqual | kGreater | (is_float ? kUnordered : 0U);
    return Alternatives{{{e.a, e.b, (is_negated ? ~relations_of(e.op) : relations_of(e.op)) & all}}};
  }

 private:
  static std::optional<Alternatives> either(Alternatives left, const Alternatives& right) {
    left.insert(left.end(), right.begin(), right.end());
    if (left.size() > kMostAlternatives) return std::nullopt;
    return left;
  }
  static std::optional<Alternatives> both(const Alternatives& left, const Alternatives& right) {
    if (left.size() * right.size() > kMostAlternatives) return std::nullopt;
    Alternatives out;
    for (const Alternative& a : left) {
      for (const Alternative& b : right) {
        out.push_back(a);
        out.back().insert(out.back().end(), b.begin(), b.end());
      }
    }
    return out;
  }

  const CodeTable& code_;
};

/// The ints that compare with a constant in one of these ways; of `!=` all.
struct Range {
  std::int64_t low, high;
};
Range range_of(unsigned relations, std::int64_t constant) {
  Range out{std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()};
  if ((relations & kLess) == 0) out.low = (relations & kEqual) != 0 ? constant : constant + 1;
  if ((relations & kGreater) == 0) out.high = (relations & kEqual) != 0 ? constant : constant - 1;
  return out;
}

class GuardComparison {
 public:
  explicit GuardComparison(const CodeTable& code) : code_(code) {}

  bool exclude(const Alternative& first, const Alternative& second) const {
    // Also what contradicts itself holds never.
    Alternative all = first;
    all.insert(all.end(), second.begin(), second.end());
    for (std::size_t a = 0; a < all.size(); ++a) {
      for (std::size_t b = a + 1; b < all.size(); ++b)
        if (exclude(all[a], all[b])) return true;
    }
    return false;
  }

 private:
  bool exclude(const Comparison& a, const Comparison& b) const {
    if (are_equal(a.left, b.left) && are_equal(a.right, b.right)) return (a.relations & b.relations) == 0;
    if (!a.right.is_valid() || !b.right.is_valid()) return false;
    if (are_equal(a.left, b.right) && are_equal(a.right, b.left)) return (a.relations & mirrored(b.relations)) == 0;
    const std::optional<Limit> x = limit_of(a), y = limit_of(b);
    if (!x || !y || !are_equal(x->value, y->value)) return false;
    return std::max(x->range.low, y->range.low) > std::min(x->range.high, y->range.high);
  }

  /// An int beside a constant.
  struct Limit {
    ExprId value;
    Range range;
  };
  std::optional<Limit> limit_of(const Comparison& c) const {
    const Expr &left = code_.exprs[c.left], &right = code_.exprs[c.right];
    if (left.type != Type::Int) return std::nullopt;
    if (right.op == Op::ConstInt) return Limit{c.left, range_of(c.relations, right.int_value)};
    if (left.op == Op::ConstInt) return Limit{c.right, range_of(mirrored(c.relations), left.int_value)};
    return std::nullopt;
  }

  /// Do both give the same value? No calls: C++ may answer otherwise each time.
  bool are_equal(ExprId first, ExprId second) const {
    if (first.is_valid() != second.is_valid()) return false;
    if (!first.is_valid()) return true;
    const Expr &a = code_.exprs[first], &b = code_.exprs[second];
    if (a.op != b.op || a.type != b.type || a.op == Op::Call) return false;
    return a.index == b.index && a.int_value == b.int_value && a.float_value == b.float_value && are_equal(a.a, b.a) &&
           are_equal(a.b, b.b);
  }

  const CodeTable& code_;
};

/// What bounds leave of the values of a clock, or of a difference.
struct ClockRange {
  std::int64_t low = -kMaxTicks - 1, high = kMaxTicks + 1;
  bool is_low_open = false, is_high_open = false;

  void meet(const Bound& bound) {
    switch (bound.op) {
      case BoundOp::Lt: return meet_high(bound.ticks, true);
      case BoundOp::Le: return meet_high(bound.ticks, false);
      case BoundOp::Gt: return meet_low(bound.ticks, true);
      case BoundOp::Ge: return meet_low(bound.ticks, false);
      case BoundOp::Eq: meet_low(bound.ticks, false); return meet_high(bound.ticks, false);
    }
    BIP_UNREACHABLE("a bound of no kind");
  }
  [[nodiscard]] bool is_empty() const { return low > high || (low == high && (is_low_open || is_high_open)); }

 private:
  void meet_low(std::int64_t ticks, bool is_open) {
    if (ticks < low) return;
    is_low_open = is_open || (ticks == low && is_low_open);
    low = ticks;
  }
  void meet_high(std::int64_t ticks, bool is_open) {
    if (ticks > high) return;
    is_high_open = is_open || (ticks == high && is_high_open);
    high = ticks;
  }
};

}  // namespace

bool are_exclusive(const TimeGuard& first, const TimeGuard& second) {
  std::vector<Bound> both = first.bounds;
  both.insert(both.end(), second.bounds.begin(), second.bounds.end());
  return std::any_of(both.begin(), both.end(), [&](const Bound& of) {
    ClockRange range;
    for (const Bound& bound : both) {
      if (bound.variable == Bound::kNone && bound.clock == of.clock && bound.minus == of.minus) range.meet(bound);
    }
    return range.is_empty();
  });
}

bool are_exclusive(const CodeTable& code, ExprId first, ExprId second) {
  if (!first.is_valid() || !second.is_valid()) return false;
  const GuardReader reader(code);
  const std::optional<Alternatives> a = reader.read(first, false), b = reader.read(second, false);
  if (!a || !b) return false;
  const GuardComparison comparer(code);
  return std::all_of(a->begin(), a->end(), [&](const Alternative& x) {
    return std::all_of(b->begin(), b->end(), [&](const Alternative& y) { return comparer.exclude(x, y); });
  });
}

}  // namespace bip
