// What the rest of the system does to the data of atoms: which slots `down` may write when a port fires, which slots
// guards of connectors read, which slots cannot be followed at all. By atom type, over all its instances.
//
// Cost: linear in connectors and code.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/system/system.hpp"

namespace bip::verify {

struct TypeAccess {
  std::vector<std::vector<std::uint32_t>> written;  // by port: slots that a transfer may change before the port fires
  std::vector<std::uint8_t> observed;               // by slot: decides, directly or not, what is enabled
  std::vector<std::uint8_t> unfollowed;             // by slot: may change behind our back (references given to C++)
  std::vector<std::vector<std::uint32_t>> read;     // by port: slots that a connector reads there
  std::vector<std::uint8_t> read_anywhere;          // by slot: read without a port
};

/// One row an atom type.
[[nodiscard]] std::vector<TypeAccess> look_outside(const System& system);

}  // namespace bip::verify
