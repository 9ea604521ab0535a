// The functions of random_ffi.hpp behind the runtime's calling convention: written by hand here, generated, compiled
// and loaded by `bipc run`.
#pragma once
#include <string>

#include "compiler/lower/lower.hpp"

namespace bip::gen {

/// Fills functions and FFI types. The name of a function that random_ffi.hpp does not have, or nothing.
[[nodiscard]] std::string bind_ffi(lower::LoweredSystem& lowered);

}  // namespace bip::gen
