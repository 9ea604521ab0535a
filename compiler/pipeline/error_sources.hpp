// Can a run of the system end in an error at all, as far as the source shows?
#pragma once
#include "compiler/system/system_ids.hpp"

namespace bip::pipeline {

/// Returns false only if no run can end in an error: nothing divides, calls C++, has invariants, internal transitions,
/// priorities between ports or places that hold several tokens, no port has two transitions from one place, and no
/// connector comes after itself by priorities. Cost: linear in the types, their code, connectors and priorities.
[[nodiscard]] bool can_end_in_error(const System& system);

}  // namespace bip::pipeline
