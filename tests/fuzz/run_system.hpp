// What an accepted system must stand beyond being accepted: lowering, and some steps of the interpreter.
#pragma once
#include <string>

#include "compiler/system/system.hpp"

namespace bip::fuzz {

/// Lowers and runs up to 20 steps; FFI functions answer zero, FFI types are numbers. Faults and deadlocks are
/// normal ends. Returns what is wrong in one line, empty if nothing is.
[[nodiscard]] std::string try_running(const System& system);

}  // namespace bip::fuzz
