// Families: the elements of one array of components, "ROOT.ring.machine[]", and how those of two instances of one model
// correspond, whose arrays have other lengths.
//
// Arrays that grow by the same number from one instance to the other share a *dimension*: a model's array of n machines
// and its array of n - 1 channels have the same positions. Arrays of equal lengths do not grow. Which dimensions there
// are is decided once, by the largest instance and a small one.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/system/system_ids.hpp"

namespace bip {
struct System;
}

namespace bip::verify {

using u32 = std::uint32_t;

struct Family {
  std::string name;        // path with the last index left out
  u32 type = 0;            // of its atoms
  std::vector<u32> atoms;  // by index; a component without index is a family of one
};
struct Element {
  u32 family = 0, index = 0;
};
struct IndexFamilies {
  std::vector<Family> rows;      // in the order of their first atoms
  std::vector<Element> of_atom;  // by atom
};
/// Nothing if the atoms of a family differ in type, or indices are missing. Cost: linear in the atoms' paths.
[[nodiscard]] std::optional<IndexFamilies> find_families(const System& system);

/// The dimensions of the largest instance's families.
struct Dimensions {
  static constexpr u32 kFixed = 0xffffffffu;
  std::vector<u32> of_family;  // by family of the largest instance; kFixed: it does not grow
  u32 count = 0;
};
/// Nothing if a family of the large instance is missing in the small one, or grows smaller.
[[nodiscard]] std::optional<Dimensions> find_dimensions(const IndexFamilies& large, const System& large_system,
                                                        const IndexFamilies& small, const System& small_system);

/// One instance, seen from the largest one.
struct InstanceView {
  IndexFamilies families;
  std::vector<u32> family_of_large;  // by family of the largest instance: its row here
  std::vector<u32> large_family_of;  // by family here
  std::vector<u32> lengths;          // by dimension: that of its longest family
};
/// Nothing if the families of the instance do not grow as the dimensions say.
[[nodiscard]] std::optional<InstanceView> view_instance(const System& system, const IndexFamilies& large,
                                                        const System& large_system, const Dimensions& dimensions);

}  // namespace bip::verify
