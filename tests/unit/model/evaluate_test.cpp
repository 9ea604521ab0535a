// Constant evaluation: random expressions against an evaluation of their own in wide arithmetic, and the corners by
// name.
#include <catch2/catch.hpp>
#include <iterator>
#include <optional>
#include <random>

#include "compiler/model/evaluate.hpp"

namespace {

using bip::CodeTable;
using bip::Expr;
using bip::ExprId;
using bip::Op;
using bip::Type;
using bip::model::Evaluated;
using bip::model::Fault;

struct Code {
  CodeTable table{};
  ExprId number(std::int32_t v) { return table.exprs.push({.op = Op::ConstInt, .type = Type::Int, .int_value = v}); }
  ExprId truth(bool v) { return table.exprs.push({.op = Op::ConstBool, .type = Type::Bool, .int_value = v}); }
  ExprId real(double v) { return table.exprs.push({.op = Op::ConstFloat, .type = Type::Float, .float_value = v}); }
  ExprId one(Op op, Type type, ExprId a) { return table.exprs.push({.op = op, .type = type, .a = a}); }
  ExprId two(Op op, Type type, ExprId a, ExprId b) {
    return table.exprs.push({.op = op, .type = type, .a = a, .b = b});
  }
  [[nodiscard]] Evaluated operator()(ExprId e) const { return bip::model::evaluate(table, e, {}); }
};

// What an int expression should give: nothing for a fault. Wide and slow on purpose.
std::optional<std::int32_t> expected(Op op, std::int32_t a, std::int32_t b) {
  const auto wrap = [](std::int64_t v) {
    constexpr std::int64_t k = std::int64_t{1} << 32;
    std::int64_t m = ((v % k) + k) % k;
    if (m >= k / 2) m -= k;
    return static_cast<std::int32_t>(m);
  };
  const std::int64_t x = a;
  const std::int64_t y = b;
  switch (op) {
    case Op::Add: return wrap(x + y);
    case Op::Sub: return wrap(x - y);
    case Op::Mul: return wrap(x * y);
    case Op::BitAnd: return a & b;
    case Op::BitOr: return a | b;
    case Op::BitXor: return a ^ b;
    case Op::Div:
    case Op::Mod:
      break;
      BIP_LEAF_OPS(BIP_OP_CASE)
      BIP_UNARY_OPS(BIP_OP_CASE)
      BIP_LOGIC_OPS(BIP_OP_CASE)
      BIP_COMPARISON_OPS(BIP_OP_CASE)
      return std::nullopt;
  }
  if (y == 0 || (x == INT32_MIN && y == -1)) return std::nullopt;
  const std::int64_t magnitude = (x < 0 ? -x : x) / (y < 0 ? -y : y);
  const std::int64_t quotient = (x < 0) == (y < 0) ? magnitude : -magnitude;
  return wrap(op == Op::Div ? quotient : x - quotient * y);
}

TEST_CASE("random int expressions") {
  constexpr Op kOps[] = {BIP_VALUE_OPS(BIP_OP_ITEM)};
  constexpr std::int32_t kCorners[] = {0, 1, -1, 2, 7, -7, INT32_MAX, INT32_MIN, 65536, -65537};
  std::mt19937 random(7);
  std::size_t faults = 0;
  for (int round = 0; round < 3000; ++round) {
    Code code;
    const auto leaf = [&] { return random() % 2 == 0 ? kCorners[random() % 10] : static_cast<std::int32_t>(random()); };
    std::optional<std::int32_t> value = leaf();
    ExprId expr = code.number(*value);
    for (int k = 0; k < 4; ++k) {
      const Op op = kOps[random() % std::size(kOps)];
      const std::int32_t other = leaf();
      const bool left = random() % 2 == 0;
      if (value) value = left ? expected(op, *value, other) : expected(op, other, *value);
      expr =
          left ? code.two(op, Type::Int, expr, code.number(other)) : code.two(op, Type::Int, code.number(other), expr);
    }
    const Evaluated got = code(expr);
    REQUIRE((got.fault == Fault::None) == value.has_value());
    if (value) REQUIRE(got.value.int_value == *value);
    faults += value ? 0 : 1;
  }
  REQUIRE(faults > 100);
}

TEST_CASE("comparisons give bool and look at their operands' type") {
  Code code;
  for (const auto& [a, b] : {std::pair(1, 2), std::pair(2, 2), std::pair(-3, INT32_MAX)}) {
    const auto holds = [&](Op op) {
      return code(code.two(op, Type::Bool, code.number(a), code.number(b))).value.int_value == 1;
    };
    REQUIRE(holds(Op::Eq) == (a == b));
    REQUIRE(holds(Op::Ne) == (a != b));
    REQUIRE(holds(Op::Lt) == (a < b));
    REQUIRE(holds(Op::Gt) == (a > b));
    REQUIRE(holds(Op::Le) == (a <= b));
    REQUIRE(holds(Op::Ge) == (a >= b));
  }
  const Evaluated less = code(code.two(Op::Lt, Type::Bool, code.real(0.25), code.real(0.5)));
  REQUIRE(less.value.type == Type::Bool);
  REQUIRE(less.value.int_value == 1);
}

TEST_CASE("a number is not equal to itself if it is none") {
  Code code;
  const ExprId zero = code.real(0);
  const ExprId none = code.two(Op::Div, Type::Float, zero, zero);
  REQUIRE(code(none).fault == Fault::None);
  REQUIRE(code(code.two(Op::Eq, Type::Bool, none, none)).value.int_value == 0);
  REQUIRE(code(code.two(Op::Ne, Type::Bool, none, none)).value.int_value == 1);
}

TEST_CASE("the right operand of && and || is left out where the left one decides") {
  Code code;
  const ExprId bad =
      code.two(Op::Eq, Type::Bool, code.two(Op::Div, Type::Int, code.number(1), code.number(0)), code.number(1));
  REQUIRE(code(code.two(Op::And, Type::Bool, code.truth(false), bad)).value.int_value == 0);
  REQUIRE(code(code.two(Op::Or, Type::Bool, code.truth(true), bad)).value.int_value == 1);
  REQUIRE(code(code.two(Op::And, Type::Bool, code.truth(true), bad)).fault == Fault::DivisionByZero);
  REQUIRE(code(code.two(Op::Or, Type::Bool, code.truth(false), bad)).fault == Fault::DivisionByZero);
}

TEST_CASE("the smallest int has no positive twin") {
  Code code;
  const ExprId smallest = code.number(INT32_MIN);
  REQUIRE(code(code.one(Op::Neg, Type::Int, smallest)).value.int_value == INT32_MIN);
  REQUIRE(code(code.one(Op::BitNot, Type::Int, smallest)).value.int_value == INT32_MAX);
  REQUIRE(code(code.two(Op::Div, Type::Int, smallest, code.number(-1))).fault == Fault::DivisionOverflow);
  REQUIRE(code(code.two(Op::Mod, Type::Int, smallest, code.number(-1))).fault == Fault::DivisionOverflow);
}

TEST_CASE("parameters and loop variables are Self") {
  Code code;
  const ExprId load = code.table.exprs.push({.op = Op::LoadSelf, .type = Type::Int, .index = 1});
  const std::vector<bip::Value> self = {{Type::Int, 5, 0}, {Type::Int, 9, 0}};
  REQUIRE(bip::model::evaluate(code.table, code.one(Op::IntToFloat, Type::Float, load), self).value.float_value == 9.0);
}

}  // namespace
