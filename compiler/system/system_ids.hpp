// The ids of the System's tables and the names of their rows, for headers that speak of a System and do not look into
// it: what includes only this is not compiled again when the System changes.
#pragma once
#include "compiler/model/types.hpp"

namespace bip {

using AtomId = Id<struct AtomTag>;
using ConnectorId = Id<struct ConnectorTag>;
using CompoundId = Id<struct CompoundTag>;
using PriorityId = Id<struct PriorityTag>;

struct Atom;
struct Connector;
struct DataRef;
struct PortRef;
struct Priority;
struct System;

}  // namespace bip
