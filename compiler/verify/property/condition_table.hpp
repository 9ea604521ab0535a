// The conditions on states within a parsed property; internal to compiler/verify/property.
#pragma once
#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "compiler/verify/property/property.hpp"

namespace bip::verify {

/// A valuation is one word.
inline constexpr std::size_t kMaxConditions = 64;

class ConditionTable {
  static auto key_of(const PropertyNode& n) {
    return std::make_tuple(n.kind, n.type, n.op, n.a, n.b, n.int_value, n.float_value, n.owner, n.row);
  }

 public:
  /// `parsed` must outlive the table.
  explicit ConditionTable(const Property& parsed) : parsed_(parsed) {}

  /// The row of the condition that a node of the parsed property is the root of. Equal conditions share a row.
  [[nodiscard]] std::uint32_t row_of(std::uint32_t node) {
    Property condition;
    condition.root = copy_part(parsed_, node, condition);
    const auto same = std::find_if(conditions_.begin(), conditions_.end(), [&](const Property& other) {
      return std::equal(other.nodes.begin(), other.nodes.end(), condition.nodes.begin(), condition.nodes.end(),
                        [](const PropertyNode& a, const PropertyNode& b) { return key_of(a) == key_of(b); });
    });
    const auto row = static_cast<std::uint32_t>(same - conditions_.begin());
    if (same == conditions_.end()) conditions_.push_back(std::move(condition));
    return row;
  }
  [[nodiscard]] std::vector<Property> take() { return std::move(conditions_); }

 private:
  const Property& parsed_;
  std::vector<Property> conditions_;
};

}  // namespace bip::verify
