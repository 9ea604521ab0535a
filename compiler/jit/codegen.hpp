// LLVM IR for code units. Internal to jit/; the only headers of LLVM it needs are those of the IR.
#pragma once
#include <llvm/IR/Module.h>

#include <cstddef>
#include <memory>
#include <string>

#include "compiler/lower/lower.hpp"

namespace bip::jit {

/// C++ functions and data of the process, declared by name; a number follows: row of functions, of extern types, of
/// expressions (the slot of a call's extern result).
inline const std::string kFunctionName = "bip_call_", kCopyName = "bip_copy_", kTemporaryName = "bip_temporary_", kOutsideName = "bip_outside";

/// A module with the functions of units [first, first + count), named as the units, each a rt::CodeFn.
/// Promises: `nounwind`, calls of nothing but C++ functions, no fast-math, int arithmetic that wraps.
[[nodiscard]] std::unique_ptr<llvm::Module> build_module(llvm::LLVMContext& context, const lower::LoweredSystem& lowered,
                                                         std::size_t first, std::size_t count);

}  // namespace bip::jit
