// See size_value.hpp. A comparison is decided by the signs of a linear form: with i = low + x and n = i + high + 1 + y,
// x and y at least 0, a form whose coefficients of x and y have no other sign than its constant keeps that sign.
#include "compiler/verify/sizes/size_value.hpp"

#include <cstdlib>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Beyond, nothing is known: no product of what is known overflows.
constexpr std::int64_t kLargestCoefficient = 1'000'000;

SizeValue bounded_size_value(const SizeValue& v) {
  for (const std::int64_t part : {v.of_position, v.of_size, v.constant}) {
    if (std::abs(part) > kLargestCoefficient) return {};
  }
  return v;
}

SizeValue size_truth(bool truth) { return {SizeValue::Kind::Truth, 0, 0, 0, truth}; }

SizeValue sum(const SizeValue& a, const SizeValue& b, std::int64_t sign) {
  if (a.kind != SizeValue::Kind::Linear || b.kind != SizeValue::Kind::Linear) return {};
  return bounded_size_value(SizeValue::linear(a.of_position + sign * b.of_position, a.of_size + sign * b.of_size,
                                              a.constant + sign * b.constant));
}

SizeValue product(const SizeValue& a, const SizeValue& b) {
  if (b.is_constant() && a.kind == SizeValue::Kind::Linear)
    return bounded_size_value(
        SizeValue::linear(a.of_position * b.constant, a.of_size * b.constant, a.constant * b.constant));
  return a.is_constant() && b.kind == SizeValue::Kind::Linear ? product(b, a) : SizeValue();
}

// The least value of a linear form, if there is one.
std::optional<std::int64_t> least_value(const SizeValue& v, const SizeRange& range) {
  if (v.of_position == 0) {
    if (v.of_size < 0) return std::nullopt;
    return v.of_size * range.least + v.constant;
  }
  if (v.of_position + v.of_size < 0 || v.of_size < 0) return std::nullopt;
  return v.of_position * range.low + v.of_size * (range.low + range.high + 1) + v.constant;
}

std::optional<std::int64_t> greatest_value(const SizeValue& v, const SizeRange& range) {
  const std::optional<std::int64_t> least = least_value(sum(SizeValue::linear(0, 0, 0), v, -1), range);
  if (!least) return std::nullopt;
  return -*least;
}

SizeValue modulo_size(const SizeValue& a, const SizeValue& b, const SizeRange& range) {
  if (a.kind != SizeValue::Kind::Linear || b.kind != SizeValue::Kind::Linear) return {};
  if (a.is_constant() && b.is_constant() && a.constant >= 0 && b.constant > 0)
    return SizeValue::linear(0, 0, a.constant % b.constant);
  const bool is_by_size = b.of_position == 0 && b.of_size == 1 && b.constant == 0;
  const std::optional<std::int64_t> least = least_value(a, range);
  // `%` truncates: of a negative value it is no position.
  if (!is_by_size || !least || *least < 0) return {};
  if (a.of_position == 1) return {SizeValue::Kind::Circular, 1, 0, a.constant, false};
  if (a.of_position != 0 || std::abs(a.constant) >= range.least) return {};
  return SizeValue::linear(0, a.constant < 0 ? 1 : 0, a.constant);
}

SizeValue comparison(Op op, const SizeValue& a, const SizeValue& b, const SizeRange& range) {
  if (a.kind == SizeValue::Kind::Truth && b.kind == SizeValue::Kind::Truth) {
    if (op == Op::Eq) return size_truth(a.truth == b.truth);
    return op == Op::Ne ? size_truth(a.truth != b.truth) : SizeValue();
  }
  const SizeValue difference = sum(a, b, -1);
  if (difference.kind != SizeValue::Kind::Linear) return {};
  const std::optional<std::int64_t> least = least_value(difference, range);
  const std::optional<std::int64_t> greatest = greatest_value(difference, range);
  BIP_ASSERT(!least || !greatest || *least <= *greatest, "a difference from {} to {}", *least, *greatest);
  const bool is_above = least && *least > 0, is_below = greatest && *greatest < 0;
  const bool is_at_least = least && *least >= 0, is_at_most = greatest && *greatest <= 0;
  const bool is_equal = is_at_least && is_at_most;
  const auto decided = [](bool yes, bool no) { return yes ? size_truth(true) : no ? size_truth(false) : SizeValue(); };
  if (op == Op::Eq) return decided(is_equal, is_above || is_below);
  if (op == Op::Ne) return decided(is_above || is_below, is_equal);
  if (op == Op::Lt) return decided(is_below, is_at_least);
  if (op == Op::Le) return decided(is_at_most, is_above);
  if (op == Op::Gt) return decided(is_above, is_at_most);
  return decided(is_at_least, is_below);
}

}  // namespace

SizeValue evaluate_for_sizes(const CodeTable& code, ExprId expr, const std::vector<SizeValue>& self,
                             const SizeRange& range) {
  const Expr& e = code.exprs[expr];
  const auto operand = [&](ExprId id) { return evaluate_for_sizes(code, id, self, range); };
  switch (e.op) {
    case Op::ConstInt: return bounded_size_value(SizeValue::linear(0, 0, e.int_value));
    case Op::ConstBool: return size_truth(e.int_value != 0);
    case Op::LoadSelf: return e.index < self.size() ? self[e.index] : SizeValue();
    case Op::Neg: return sum(SizeValue::linear(0, 0, 0), operand(e.a), -1);
    case Op::Not: {
      const SizeValue a = operand(e.a);
      return a.kind == SizeValue::Kind::Truth ? size_truth(!a.truth) : SizeValue();
    }
    case Op::Add: return sum(operand(e.a), operand(e.b), 1);
    case Op::Sub: return sum(operand(e.a), operand(e.b), -1);
    case Op::Mul: return product(operand(e.a), operand(e.b));
    case Op::Mod: return modulo_size(operand(e.a), operand(e.b), range);
    case Op::And:
    case Op::Or: {
      const SizeValue a = operand(e.a), b = operand(e.b);
      if (a.kind != SizeValue::Kind::Truth || b.kind != SizeValue::Kind::Truth) return {};
      return size_truth(e.op == Op::And ? a.truth && b.truth : a.truth || b.truth);
    }
    case Op::Eq:
    case Op::Ne:
    case Op::Lt:
    case Op::Gt:
    case Op::Le:
    case Op::Ge: return comparison(e.op, operand(e.a), operand(e.b), range);
    case Op::ConstFloat:
    case Op::ConstString:
    case Op::LoadBind:
    case Op::Call:
    case Op::IntToFloat:
    case Op::BitNot:
    case Op::Div:
    case Op::BitAnd:
    case Op::BitOr:
    case Op::BitXor: return {};
  }
  return {};
}

}  // namespace bip::verify
