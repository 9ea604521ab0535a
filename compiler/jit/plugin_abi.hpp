// Whether libbipc_jit.so was built with the types of the program that loads it.
#pragma once
#include <cstdint>

#include "compiler/jit/jit.hpp"
#include "compiler/lower/lower.hpp"
#include "compiler/system/system.hpp"

namespace bip::jit {

/// Changes whenever a type that crosses changes; the sizes catch a forgotten change.
constexpr std::uint64_t kPluginAbi = (std::uint64_t{3} << 48) + (sizeof(JitOptions) << 40) + (sizeof(MadeCode) << 32) +
                                     (sizeof(lower::LoweredSystem) << 24) + (sizeof(System) << 8) + sizeof(Expr);

}  // namespace bip::jit
