// Random well-typed code over a few variables of every type, with the constants at which arithmetic goes wrong.
#pragma once
#include <array>
#include <random>

#include "runtime/include/bip/image.hpp"
#include "tests/unit/lower/hand_built.hpp"

namespace bip::test {

/// Interactions 0-2 int, 3-4 bool, 5-6 float, 7 string; the same numbers serve as Self or as Bind.
inline const std::array<Type, 8> kRandomTypes = {Type::Int,  Type::Int,   Type::Int,   Type::Bool,
                                                 Type::Bool, Type::Float, Type::Float, Type::String};

class RandomCode {
 public:
  RandomCode(CodeTable& table, std::uint32_t seed, bool with_bind)
      : code_{table}, random_(seed), with_bind_(with_bind) {}

  ExprId expr(Type type, int depth) {
    if (depth <= 0 || pick(6) == 0) return leaf(type);
    switch (type) {
      case Type::Int: return int_expr(depth - 1);
      case Type::Bool: return bool_expr(depth - 1);
      case Type::Float: return float_expr(depth - 1);
      case Type::String: break;
    }
    return leaf(type);
  }
  StmtId body(int length, int depth) {
    StmtId first, last;
    for (int k = 0; k < length; ++k) {
      const StmtId next = stmt(depth);
      if (last.is_valid()) code_.table.stmts[last].next = next;
      if (!first.is_valid()) first = next;
      last = next;
    }
    return first;
  }

 private:
  std::uint32_t pick(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }

  std::uint32_t variable(Type type) {
    std::uint32_t k = pick(8);
    while (kRandomTypes[k] != type) k = (k + 1) % 8;
    return k;
  }
  ExprId leaf(Type type) {
    if (pick(3) != 0) {
      const std::uint32_t k = variable(type);
      return with_bind_ && pick(2) == 0 ? code_.bind(k, type) : code_.self(k, type);
    }
    static const std::array<std::int32_t, 8> kInts = {0, 1, -1, 2, 7, INT32_MIN, INT32_MAX, -10};
    static const std::array<double, 8> kFloats = {0, -0.0, 1.5, -2.25, 1e300, 1e-310, 0.1, 3};
    switch (type) {
      case Type::Int: return code_.i(kInts[pick(8)]);
      case Type::Bool: return code_.b(pick(2) == 0);
      case Type::Float: return code_.f(kFloats[pick(8)]);
      case Type::String: break;
    }
    return code_.s(pick(2) == 0 ? "" : "a \"b\" */ ?\?/ \\\n");
  }
  ExprId int_expr(int depth) {
    // Divisions twice as often.
    static constexpr auto kOps = std::to_array<Op>({BIP_VALUE_OPS(BIP_OP_ITEM) BIP_DIVISION_OPS(BIP_OP_ITEM)});
    constexpr std::uint32_t kCount = kOps.size();
    const std::uint32_t k = pick(kCount + 2);
    if (k < kCount) return code_.binary(kOps[k], expr(Type::Int, depth), expr(Type::Int, depth));
    return code_.unary(k == kCount ? Op::Neg : Op::BitNot, expr(Type::Int, depth));
  }
  ExprId bool_expr(int depth) {
    static constexpr auto kCompare = std::to_array<Op>({BIP_COMPARISON_OPS(BIP_OP_ITEM)});
    const std::uint32_t k = pick(6);
    if (k < 2) return code_.binary(k == 0 ? Op::And : Op::Or, expr(Type::Bool, depth), expr(Type::Bool, depth));
    if (k == 2) return code_.unary(Op::Not, expr(Type::Bool, depth));
    const auto type = static_cast<Type>(pick(4));
    const bool ordered = type == Type::Int || type == Type::Float;
    return code_.binary(kCompare[pick(ordered ? 6 : 2)], expr(type, depth), expr(type, depth));
  }
  ExprId float_expr(int depth) {
    static const std::array<Op, 4> kOps = {Op::Add, Op::Sub, Op::Mul, Op::Div};
    const std::uint32_t k = pick(6);
    if (k < 4) return code_.binary(kOps[k], expr(Type::Float, depth), expr(Type::Float, depth));
    if (k == 4) return code_.unary(Op::Neg, expr(Type::Float, depth));
    return code_.unary(Op::IntToFloat, expr(Type::Int, depth));
  }
  StmtId stmt(int depth) {
    if (depth > 0 && pick(3) == 0) {
      const ExprId condition = expr(Type::Bool, 3);
      const StmtId then_body = body(static_cast<int>(pick(3)), depth - 1);
      return code_.when(condition, then_body, body(static_cast<int>(pick(3)), depth - 1));
    }
    const std::uint32_t k = pick(8);
    const ExprId value = expr(kRandomTypes[k], 4);
    return with_bind_ && pick(2) == 0 ? code_.set_bind(k, value) : code_.set(k, value);
  }

  Code code_;
  std::mt19937 random_;
  bool with_bind_;
};

/// A state of the 8 variables, edge values preferred.
inline std::array<rt::Cell, 8> random_interactions(std::mt19937& random) {
  static const std::array<std::int32_t, 6> kInts = {0, -1, 1, INT32_MIN, INT32_MAX, 5};
  static const std::array<double, 6> kFloats = {0, -1.5, 1e308, 0.1, -0.0, 3};
  std::array<rt::Cell, 8> cells{};
  for (std::size_t k = 0; k < cells.size(); ++k) {
    switch (kRandomTypes[k]) {
      case Type::Int: cells[k].bits = static_cast<std::uint32_t>(kInts[random() % 6]); break;
      case Type::Float: cells[k].f = kFloats[random() % 6]; break;
      case Type::Bool:
      case Type::String: cells[k].bits = random() % 2; break;
    }
  }
  return cells;
}

}  // namespace bip::test
