// How the words of a program are laid out; see programs.cpp, which writes them, and run_program.cpp, which reads them.
#pragma once
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

inline constexpr u32 kPure = 1, kWide = 2;
inline constexpr u32 kDeltaLast = 1u << 5;
/// The program is elsewhere: at the row that the other bits say.
inline constexpr u32 kFar = 1u << 31;

}  // namespace bip::rt
