// LLVM IR for code units. Internal to jit/; the only headers of LLVM it needs are those of the IR.
#pragma once
#include <llvm/IR/Module.h>

#include <cstddef>
#include <memory>

#include "compiler/lower/lower.hpp"

namespace bip::jit {

/// A module with the functions of units [first, first + count), named as the units, each a rt::CodeFn.
/// Promises: `nounwind`, no calls, no fast-math, int arithmetic that wraps.
[[nodiscard]] std::unique_ptr<llvm::Module> build_module(llvm::LLVMContext& context, const lower::LoweredSystem& lowered,
                                                         std::size_t first, std::size_t count);

}  // namespace bip::jit
