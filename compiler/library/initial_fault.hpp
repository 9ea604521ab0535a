// Does a model end with a run-time error before its first state? Then nothing that is proved of its states says
// anything.
#pragma once
#include <string>

#include "compiler/system/system_ids.hpp"

namespace bip::library {

/// The error of the initialization, in one line; empty: there is none. Requires a system without C++. Cost: a pass over
/// the code; the system is lowered and initialized only if something in it may fail.
[[nodiscard]] std::string initial_fault(const System& system);

}  // namespace bip::library
