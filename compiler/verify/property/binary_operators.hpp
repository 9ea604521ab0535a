// The signs of C's operators with two operands, as properties have them. Internal to compiler/verify/property.
#pragma once
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/model/operators.hpp"
#include "compiler/verify/property/property.hpp"

namespace bip::verify {

struct BinaryOperator {
  std::string_view sign;
  Op op;
  int level;
};
/// Returns all binary operators, longer signs first.
inline const std::vector<BinaryOperator>& binary_operators() {
  static const std::vector<BinaryOperator> kBinaryOperators = [] {
    std::vector<BinaryOperator> rows;
    for (std::size_t row = 0; row < kOperators.size(); ++row) {
      const Op op = static_cast<Op>(row);
      if (operand_count(op) == 2) rows.push_back({symbol_of(op), op, static_cast<int>(precedence_of(op))});
    }
    std::stable_sort(rows.begin(), rows.end(),
                     [](const BinaryOperator& a, const BinaryOperator& b) { return a.sign.size() > b.sign.size(); });
    return rows;
  }();
  return kBinaryOperators;
}

/// What was meant by an operator that does not take this left side; empty: who knows.
[[nodiscard]] inline std::string hint_of(Op op, const PropertyNode& left) {
  if (left.type != Type::Bool) return {};
  if (op == Op::BitAnd) return ": `&&` joins conditions";
  if (op == Op::BitOr) return ": `||` joins conditions";
  const bool is_chain = is_order(op) && left.kind == PropertyKind::Operator && is_comparison(left.op);
  return is_chain ? ": a chain of comparisons is written `a <= b && b <= c`" : "";
}

}  // namespace bip::verify
