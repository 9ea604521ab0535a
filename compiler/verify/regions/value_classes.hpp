// Which variables hold values of one kind: they are compared with each other, or one is assigned to the other. And
// which constants code compares them with or assigns to them.
//
// Guards and actions change what they do at these constants only, as far as they compare and count; so they say where
// the values of a variable are worth telling apart. Precision only; soundness is unaffected.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/system/system.hpp"

namespace bip::verify {

using u32 = std::uint32_t;

struct ValueClasses {
  /// A constant expression over an atom's parameters; `offset` is added to its value.
  struct Attached {
    ExprId expr;
    u32 value_class = 0;
    std::int64_t offset = 0;
  };
  u32 count = 0;
  std::vector<std::vector<u32>> class_of;          // by atom type and variable
  std::vector<std::vector<u32>> class_of_bind;     // by connector type and bound variable
  std::vector<std::vector<Attached>> attached;     // by atom type
  std::vector<std::vector<std::int64_t>> general;  // by class: constants of connectors' code, sorted
};

/// Requires connectors that are bound to ports of atoms. Linear in the code and in the connectors.
[[nodiscard]] ValueClasses find_value_classes(const System& system);

}  // namespace bip::verify
