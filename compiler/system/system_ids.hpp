// The ids of the System's tables and the names of their rows, for headers that speak of a System and do not look into
// it: what includes only this is not compiled again when the System changes.
#pragma once
#include <cstdint>

#include "compiler/model/types.hpp"

namespace bip {

using AtomId = Id<struct AtomTag>;
using ConnectorId = Id<struct ConnectorTag>;
using CompoundId = Id<struct CompoundTag>;
using PriorityId = Id<struct PriorityTag>;

struct Atom;
struct Connector;
struct PortRef;
struct Priority;
struct System;

/// A data variable of an atom.
struct DataRef {
  AtomId atom;
  std::uint32_t variable = 0;
  friend bool operator==(const DataRef&, const DataRef&) = default;
};

}  // namespace bip
