// What a core is asked with and what it answers in: options, candidates, participants, whole states.
#pragma once
#include "runtime/core/state/ffi_data.hpp"
#include "runtime/core/time/interval.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

struct CoreOptions {
  MaximalProgress progress = MaximalProgress::On;
  std::uint32_t internal_bound = 1000000;      // internal transitions in a row
  std::uint32_t enumeration_bound = 1u << 16;  // interactions of one connector, when they must be listed
  std::uint32_t descent_bound = 1u << 8;  // configurations whose guards were false after which a search goes by ranges
};

/// A step that may be taken: an interaction of a connector, or an internal port of an atom (connector == kNone).
struct Candidate {
  InteractionId interaction{0u};  // canonical order: interactions, then configurations
  u32 connector = kNone;
  u32 atom = kNone, port = kNone;  // internal port
  u32 config = 0;                  // row among the interaction's configurations
};
/// A participant: an atom's port, or (direct participants only) the exported port of a connector.
struct Participant {
  u32 param = 0;
  u32 atom = kNone, port = kNone;
  u32 connector = kNone;
};

/// What a stable state is: markings and the atoms' data. Everything else follows from it.
struct State {
  std::vector<u32> places;            // by atom; for Petri types unused (0)
  std::vector<u64> marks;             // bitsets of the Petri types' atoms, in atom order
  IndexVector<VariableId, u64> data;  // the atoms' variables, as bits; of FFI types 0
  std::vector<FfiValue> objects;      // of the atoms' variables of FFI types, in their order
  std::vector<i64> time;              // of images with time: Clocks::save
  friend bool operator==(const State&, const State&) = default;
};

}  // namespace bip::rt
