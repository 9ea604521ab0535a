// Can a run of the system end in an error at all, as far as the source shows?
#pragma once
#include "compiler/system/system.hpp"

namespace bip::pipeline {

/// Returns false only if no run can end in an error: nothing divides, calls C++, has invariants, internal transitions,
/// priorities or places that hold several tokens, and no port has two transitions from one place. Cost: linear in the
/// types and their code.
[[nodiscard]] bool can_end_in_error(const System& system);

}  // namespace bip::pipeline
