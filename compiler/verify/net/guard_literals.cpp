// See guard_literals.hpp. Recursion follows the code's trees, whose depth the parser and .bsys reader bound.
#include "compiler/verify/net/guard_literals.hpp"

#include <bit>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

// The expression in prefix form, data by where it is. False: it can fault, or reads what is not an atom's.
bool GuardLiterals::add_key(ExprId id, const Locate& locate, Key& key) const {
  const Expr& e = code_.exprs[id];
  if (is_ffi(e.type)) return false;
  key.push_back(static_cast<std::int64_t>(e.op));
  switch (e.op) {
    case Op::ConstInt:
    case Op::ConstBool:
    case Op::ConstString: key.push_back(e.int_value); return true;
    case Op::ConstFloat: key.push_back(std::bit_cast<std::int64_t>(e.float_value)); return true;
    case Op::LoadSelf:
    case Op::LoadBind: {
      const std::optional<Place> place = locate(e);
      if (!place) return false;
      key.back() = static_cast<std::int64_t>(Op::LoadBind);
      key.push_back(place->atom);
      key.push_back(place->variable);
      return true;
    }
    case Op::IntToFloat:
    case Op::Neg:
    case Op::Not:
    case Op::BitNot: return add_key(e.a, locate, key);
    case Op::Call:
    case Op::Div:
    case Op::Mod:
      return false;
      BIP_ARITHMETIC_OPS(BIP_OP_CASE)
      BIP_BITWISE_OPS(BIP_OP_CASE)
      BIP_LOGIC_OPS(BIP_OP_CASE)
      BIP_COMPARISON_OPS(BIP_OP_CASE)
      return add_key(e.a, locate, key) && add_key(e.b, locate, key);
  }
  BIP_UNREACHABLE("operator");
}

Lit GuardLiterals::always() {
  if (always_ == 0) {
    always_ = solver_.new_variable();
    solver_.add({always_});
  }
  return always_;
}

std::optional<Lit> GuardLiterals::comparison(const Expr& e, const Locate& locate) {
  Key a, b;
  if (!add_key(e.a, locate, a) || !add_key(e.b, locate, b)) return std::nullopt;
  const bool is_turned = b < a;
  if (is_turned) std::swap(a, b);
  const bool is_same = a == b;
  const auto [found, is_new] = orders_.try_emplace({std::move(a), std::move(b)});
  std::array<Lit, 3>& order = found->second;
  if (is_new) {
    for (Lit& literal : order) literal = solver_.new_variable();
    solver_.add(order);
    add_at_most_one(solver_, order);
    if (is_same) solver_.add({order[1]});
  }
  const Lit less = order[is_turned ? 2 : 0], greater = order[is_turned ? 0 : 2];
  switch (e.op) {
    case Op::Eq: return order[1];
    case Op::Ne: return -order[1];
    case Op::Lt: return less;
    case Op::Gt: return greater;
    case Op::Le: return -greater;
    case Op::Ge:
      return -less;
      BIP_NO_COMPARISON_OPS(BIP_OP_CASE)
      break;
  }
  BIP_UNREACHABLE("not a comparison");
}

std::optional<Lit> GuardLiterals::joined(const Expr& e, const Locate& locate) {
  const std::optional<Lit> a = literal(e.a, locate), b = literal(e.b, locate);
  if (!a || !b) return std::nullopt;
  const Lit sign = e.op == Op::And ? 1 : -1;
  // Of an `or` the same with all signs turned.
  const Lit both = solver_.new_variable();
  solver_.add({-both, sign * *a});
  solver_.add({-both, sign * *b});
  solver_.add({both, -sign * *a, -sign * *b});
  return sign * both;
}

std::optional<Lit> GuardLiterals::literal(ExprId id, const Locate& locate) {
  if (!id.is_valid()) return always();
  const Expr& e = code_.exprs[id];
  switch (e.op) {
    case Op::ConstBool: return e.int_value != 0 ? always() : -always();
    case Op::And:
    case Op::Or: return joined(e, locate);
    case Op::Not: {
      const std::optional<Lit> inner = literal(e.a, locate);
      return inner ? std::optional(-*inner) : std::nullopt;
    }
      BIP_COMPARISON_OPS(BIP_OP_CASE)
      if (code_.exprs[e.a].type == Type::Int) return comparison(e, locate);
      break;
    case Op::ConstInt:
    case Op::ConstFloat:
    case Op::ConstString:
    case Op::Neg:
    case Op::BitNot:
      BIP_LOAD_OPS(BIP_OP_CASE)
      BIP_CALL_OPS(BIP_OP_CASE)
      BIP_CONVERSION_OPS(BIP_OP_CASE)
      BIP_VALUE_OPS(BIP_OP_CASE)
      break;
  }
  Key key;
  if (!add_key(id, locate, key)) return std::nullopt;
  const auto [found, is_new] = known_.try_emplace(std::move(key), 0);
  if (is_new) found->second = solver_.new_variable();
  return found->second;
}

}  // namespace bip::verify
