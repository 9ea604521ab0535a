// Is a property the same after components have changed places? Compared are the expressions, up to the order of
// operands of commutative operators and the nesting of associative ones: `a@P || b@P || c@P` is preserved by every
// permutation of a, b and c. Sound and incomplete: what is equal for another reason counts as different.
//
// E. M. Clarke, R. Enders, T. Filkorn, S. Jha: Exploiting Symmetry in Temporal Logic Model Checking (1996): a quotient
// by permutations that preserve the atomic propositions satisfies the same properties.
#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "compiler/verify/property/property.hpp"

namespace bip::verify {

/// Compares one property with its images under exchanges.
class PropertyImages {
 public:
  /// Refers to `property`, which must outlive it. Linear in its expression, times its height at most.
  explicit PropertyImages(const Property& property);
  /// Is the property preserved if each of these atoms is replaced by the other one? They must be of one type.
  /// Connectors are taken to stay where they are. Cost as of the constructor.
  [[nodiscard]] bool is_preserved_by(const std::map<std::uint32_t, std::uint32_t>& exchange) const;

 private:
  using Term = std::vector<std::uint32_t>;
  // The class of equal expressions of the root's image; `terms` numbers the classes.
  [[nodiscard]] std::uint32_t class_of(const std::map<std::uint32_t, std::uint32_t>& exchange,
                                       std::map<Term, std::uint32_t>& terms) const;

  const Property& property_;
  std::vector<std::uint8_t> is_inner_;  // by node: only operand of the same associative operator
  std::map<Term, std::uint32_t> terms_;
  std::uint32_t root_class_ = 0;
};

}  // namespace bip::verify
