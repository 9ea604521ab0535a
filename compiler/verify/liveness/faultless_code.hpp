// Which atom types and connector types have code that never ends a step in a run-time error, whatever the state: by
// their text and the ranges of their data. Sound and incomplete.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/verify/regions/region_net.hpp"

namespace bip::verify {

struct FaultlessCode {
  std::vector<std::uint8_t> is_atom;       // by atom
  std::vector<std::uint8_t> is_connector;  // by connector
  /// Of all atoms and connectors.
  [[nodiscard]] bool has_all() const;
};

/// Faultless: no invariant and no call but draws whose arguments are good; no division by what may be 0 or -1; a single
/// token; of two transitions of one port, or two internal ones, that leave one place the guards exclude each other;
/// internal transitions go round no places; no rule among ports. Nothing is where the system has priorities, which may
/// be cyclic. Linear in the code of each atom, and quadratic in the transitions that leave one place.
[[nodiscard]] FaultlessCode find_faultless_code(const RegionNet& net);

}  // namespace bip::verify
