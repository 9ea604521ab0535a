// The entry points of libbipc_jit.so. They have C names, so that the driver finds them with dlsym. C++ types may be
// passed, because program and plug-in are built by one compiler from one tree; `bipc_jit_abi` detects a plug-in that
// was not.
#pragma once
#include <cstdint>
#include <string>

#include "compiler/jit/jit.hpp"
#include "compiler/lower/lower.hpp"

namespace bip::jit {

enum class Listing : std::uint8_t { Llvm, Asm };

extern "C" {
using AbiFn = std::uint64_t();
/// Jit::compile: the Jit, or null and the reason in `error`. Freed by DestroyFn.
using CompileFn = Jit*(const lower::LoweredSystem* lowered, const JitOptions* options, MadeCode* made,
                       std::string* error);
using DestroyFn = void(Jit* jit);
/// The text in `out`, or false and the reason there.
using EmitFn = bool(const lower::LoweredSystem* lowered, OptLevel level, Listing kind, std::string* out);
}
inline constexpr const char* kAbiName = "bipc_jit_abi";
inline constexpr const char* kCompileName = "bipc_jit_compile";
inline constexpr const char* kDestroyName = "bipc_jit_destroy";
inline constexpr const char* kEmitName = "bipc_jit_emit";

}  // namespace bip::jit
