// What a node of a distributed run says of a fault (Control::Kind::Fault), written and read: step, order, code, atom,
// connector, port and two places in files as numbers, and four texts.
#pragma once
#include <optional>

#include "runtime/core/fire/fault.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/distributed/message.hpp"

namespace bip::rt {

/// A fault of a step, as its `order`-th; of all faults of a run the first one is the run's.
struct FaultOfStep {
  u64 step = 0, order = 0;
  Fault fault;
};

[[nodiscard]] Control fault_message(u64 step, u32 order, const Fault& fault);
/// Nothing if it is none. Rows that the image does not have are none.
[[nodiscard]] std::optional<FaultOfStep> read_fault_message(const Control& control, const Image& image);

}  // namespace bip::rt
