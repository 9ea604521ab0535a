// An inner order of atoms, interactions and variables, for models whose source has none: flat texts in random order.
//
// Interactions of one class (connector type, types and ports of its atoms) follow one another along chains, if they
// form some: the next one binds to an early parameter the atom that this one binds to a later parameter, as around a
// ring. Atoms are numbered by type as the interactions mention them. So the neighbours of a ring, a chain or a set of
// pairs have numbers at fixed distances, wherever the source declares them. O(n log n) for n interactions.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::steps {

struct InnerOrder {
  std::vector<rt::u32> atoms, interactions, cells;  // by inner number: the core's
  std::vector<rt::u32> first_of_class;              // by inner interaction: the first one of its class
  std::vector<rt::u32> cell_distance;  // by inner cell: from a variable of an owner to the same one of the next owner
};

[[nodiscard]] InnerOrder find_inner_order(const rt::Image& image, const rt::Tables& tables);

}  // namespace bip::steps
