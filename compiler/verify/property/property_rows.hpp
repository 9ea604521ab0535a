// The rows of a property while it is parsed: what is known of each of them, what joins them, and what variables of
// quantifiers decide. Internal to compiler/verify/property.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/verify/property/make_formula.hpp"
#include "compiler/verify/property/property.hpp"
#include "compiler/verify/property/property_text.hpp"
#include "compiler/verify/property/quantifier.hpp"

namespace bip::verify {

class PropertyRows : protected PropertyText {
 protected:
  explicit PropertyRows(const std::string& text) : PropertyText(text) {}
  ~PropertyRows() = default;
  PropertyRows(const PropertyRows&) = delete;
  PropertyRows& operator=(const PropertyRows&) = delete;

  /// After a problem rows are placeholders.
  std::uint32_t add(PropertyNode node);
  std::uint32_t constant(Type type, std::int32_t value);
  std::uint32_t make_condition(Op op, std::uint32_t a, std::uint32_t b);
  std::uint32_t make_not(std::uint32_t a);
  /// `a && b` or `a || b`, of conditions or formulas; what variables decide is left out. The operands are the rows from
  /// `mark` on.
  std::uint32_t join(Op op, std::uint32_t a, std::uint32_t b, std::size_t mark);
  /// What a quantifier makes of its rows, which begin at `mark`. `limit`: the number of one that counts; `known`: so
  /// many more are true whatever the state; `is_decided`: variables decided it.
  std::uint32_t join_all(IndexQuantifier quantifier, const std::vector<std::uint32_t>& rows,
                         std::optional<std::int64_t> limit, std::size_t known, bool is_decided, std::size_t mark);
  /// Removes the rows from this one on.
  void forget_from(std::size_t row);

  [[nodiscard]] Type type(std::uint32_t row) const;
  /// Is it about a run, not about one state?
  [[nodiscard]] bool is_temporal(std::uint32_t row) const;
  /// Is its value known where variables are bound?
  [[nodiscard]] bool is_folded(std::uint32_t row) const;
  /// The number that a row is, if it is written as one.
  [[nodiscard]] std::optional<std::int32_t> constant_of(std::uint32_t row) const;

  /// When does a division in this expression fault, of those that C evaluates? A row, or kNoRow: never. The parser has
  /// limited the depth; rows of operands are shared.
  std::uint32_t fault_of(std::uint32_t row);
  /// A state in which a division faults violates the property. After this no value of such a division matters.
  void guard_divisions();

  Property property_;
  // The last row that a quantifier made, and what it counts: it is true, or, if it is negated, false, exactly where so
  // many rows are true.
  struct CountedRow {
    std::uint32_t made = Property::kNoRow;
    bool is_negated = false;
    Property::Counted counted;
  };
  CountedRow last_counted_;
  // By node.
  std::vector<std::uint8_t> is_temporal_, is_of_past_, looks_ahead_;
  std::vector<TextExtent> extents_;  // of temporal operators
  int quantifiers_ = 0;              // that are open

 private:
  std::uint32_t make_either(std::uint32_t a, std::uint32_t b);
  std::uint32_t fault_of_division(std::uint32_t a, std::uint32_t b);

  std::size_t written_ = 0;  // rows outside of quantifiers
};

}  // namespace bip::verify
