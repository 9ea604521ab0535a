// What `bipc run` compiles and loads, here by hand: the functions of outside.hpp behind the runtime's calling
// convention.
#pragma once
#include <string>

#include "compiler/lower/lower.hpp"

namespace bip::gen {

/// Fills functions and extern types. The name of a function that outside.hpp does not have, or nothing.
[[nodiscard]] std::string bind_outside(lower::LoweredSystem& lowered);

}  // namespace bip::gen
