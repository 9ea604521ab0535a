// Properties that compounds state are read when the system is built, also if no command decides them.
#pragma once
#include "compiler/diag/diagnostics.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::pipeline {

/// Reports the first problem of each property of the system at its place in the source (B4030). Cost: linear in
/// the system and the texts.
void check_properties(const System& system, Diagnostics& diags);

}  // namespace bip::pipeline
