// How much LLVM's passes do.
#pragma once
#include <cstdint>

namespace bip::jit {

enum class OptLevel : std::uint8_t { O0, O2 };

}  // namespace bip::jit
