// What the rest of the system does to the data of atoms: which variables `down` may write when a port fires, which
// variables guards of connectors read, which variables cannot be followed at all. By atom type, over all its instances.
//
// Cost: linear in connectors and code.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/system/system.hpp"

namespace bip::verify {

struct DataAccess {
  std::vector<std::vector<std::uint32_t>>
      written;                                   // by port: variables that a transfer may change before the port fires
  std::vector<std::uint8_t> observed;            // by variable: decides, directly or not, what is enabled
  std::vector<std::uint8_t> unfollowed;          // by variable: may change behind our back (references given to C++)
  std::vector<std::vector<std::uint32_t>> read;  // by port: variables that a connector reads there
  std::vector<std::uint8_t> read_anywhere;       // by variable: read without a port
};

/// One row an atom type.
[[nodiscard]] std::vector<DataAccess> analyze_data_access(const System& system);

}  // namespace bip::verify
