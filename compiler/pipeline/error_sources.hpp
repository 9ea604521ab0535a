// Can a run of the system end in an error at all, as far as the source shows?
#pragma once
#include "compiler/system/system_ids.hpp"

namespace bip::pipeline {

/// Returns false only if no run can end in an error: nothing divides but by constants and parameters other than 0 and
/// -1, calls C++, sets a clock to what may be no time, has invariants on data, internal transitions, priorities between
/// ports or places that hold several tokens, two transitions of one port from one place exclude each other, and no
/// connector comes after itself by priorities. Cost: quadratic in an atom type's transitions, linear in atoms times
/// atom types, code, connectors and priorities.
[[nodiscard]] bool can_end_in_error(const System& system);

}  // namespace bip::pipeline
