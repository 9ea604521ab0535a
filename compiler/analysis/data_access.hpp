// Which data of atoms code reads and writes: which variables `down` may write when a port fires, which variables the
// guards of connectors read, which variables cannot be followed at all. By atom type, the union over all its instances.
//
// Needs a valid System. Sound for abstraction: what may be written is listed as written, what may be read as read. A
// variable is observed if a guard reads it, or if an observed variable is computed from it (the backward slice of the
// guards; Weiser 1984). Cost: linear in connectors and code, times the length of the longest chain of assignments.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/system/system_ids.hpp"

namespace bip::analysis {

/// Lists are sorted and without duplicates.
struct DataAccess {
  std::vector<std::vector<std::uint32_t>> written;  // by port: variables that `down` may change before the port fires
  std::vector<std::uint8_t> observed;               // by variable: decides, directly or not, what is enabled
  std::vector<std::uint8_t> unfollowed;             // by variable: may change elsewhere (references given to C++)
  std::vector<std::vector<std::uint32_t>> read;     // by port: variables that a connector reads there
  std::vector<std::uint8_t> read_anywhere;          // by variable: read without a port
};

/// Returns one row per atom type.
[[nodiscard]] std::vector<DataAccess> analyze_data_access(const System& system);

}  // namespace bip::analysis
