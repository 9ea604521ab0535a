// What a core takes, by count of rows: the instances of the image, the tables, what the parts of the core keep. Not
// counted: what the image says of types, code, objects of C++ types, what vectors keep in reserve, what runs beside the
// core (engines, traces).
#pragma once
#include "runtime/core/link/interactions.hpp"

namespace bip::rt {

struct CoreParts;

/// Bytes of rows.
struct MemoryUse {
  u64 atoms = 0;       // atoms and their ports, without data
  u64 connectors = 0;  // connectors and internal ports, what counts them and the enabled ones
  u64 data = 0;        // of atoms and connectors
  u64 rest = 0;        // compounds, and what there is once or once a type; code is not counted
  [[nodiscard]] u64 all() const { return atoms + connectors + data + rest; }
};

/// Cost: linear in names and listings.
[[nodiscard]] MemoryUse memory_use(const CoreParts& core);

}  // namespace bip::rt
