// What `bipc run` compiles and loads, here by hand: the functions of outside.hpp behind the runtime's calling convention.
#pragma once
#include <memory>
#include <vector>

#include "compiler/lower/lower.hpp"

namespace bip::gen {

/// Objects that hold the results of calls; they live as long as the lowered system runs.
using OutsideObjects = std::vector<std::unique_ptr<void, void (*)(void*)>>;

/// Fills functions, extern types and temporaries. The name of a function that outside.hpp does not have is returned in
/// `missing`.
[[nodiscard]] OutsideObjects bind_outside(lower::LoweredSystem& lowered, std::string& missing);

}  // namespace bip::gen
