// What nodes say to each other. `n` counts how often an atom took part: an offer is of one n, a step takes that one,
// and whatever is about an earlier one comes too late and changes nothing.
#pragma once
#include <variant>
#include <vector>

#include "runtime/core/fire/partial.hpp"

namespace bip::rt {

/// From an atom's home to its coordinator: it is at rest, and can do this.
struct Offer {
  u32 atom = kNone;
  u64 n = 0;
  AtomOffer offer;
  std::vector<u64> cells;  // the bits of Distribution::cells
};
/// A part of a step: what one atom does.
struct Part {
  u32 atom = kNone;
  u64 n = 0;
  u32 transition = kNone;  // row of Tables::transitions
  u32 order = 0;           // in the step
  std::vector<u64> cells;  // as the connector's `down` left them
};
/// From a coordinator to a home: the parts of a step that are at home there.
struct Begin {
  u64 step = 0;
  std::vector<Part> parts;
};
/// To all other nodes: this step ended in a run-time error; begin nothing more.
struct Stop {
  u64 step = 0;
};
using Message = std::variant<Offer, Begin, Stop>;

struct Outgoing {
  u32 to = 0;
  Message message;
};

}  // namespace bip::rt
