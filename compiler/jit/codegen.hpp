// LLVM IR for code units. Internal to jit/; includes only the IR headers of LLVM.
#pragma once
#include <llvm/IR/Module.h>

#include <cstddef>
#include <memory>
#include <string>

#include "compiler/lower/lower.hpp"

namespace bip::jit {

class DebugInfo;

/// C++ functions and data of the process, declared by name; a number follows some: row of functions, of FFI types.
inline const std::string kFunctionName = "bip_call_", kCopyName = "bip_copy_", kFfiContextName = "bip_ffi_context",
                         kResultName = "bip_result", kLoweredName = "bip_lowered", kCodesName = "bip_codes",
                         kDrawName = "bip_draw";

/// A module with the functions of units [first, first + count), named as the units, each a rt::CodeFn.
/// Promises: `nounwind`, calls of nothing but C++ functions, no fast-math, int arithmetic that wraps.
/// With lines for debuggers, if there are to be any.
enum class Lines : std::uint8_t { No, Yes };
[[nodiscard]] std::unique_ptr<llvm::Module> build_module(llvm::LLVMContext& context,
                                                         const lower::LoweredSystem& lowered, std::size_t first,
                                                         std::size_t count, Lines lines = Lines::No);

/// One unit as a function of the module, called `name`. Its variables are cells; with a distance cells, self's so far
/// from each other.
llvm::Function* build_unit(llvm::Module& module, const lower::LoweredSystem& lowered, std::size_t unit,
                           const std::string& name, DebugInfo* debug, std::uint32_t distance = 0);

/// A module with a rt::StepFn for each shape of lowered.steps, named step_name(shape), and perhaps a rt::StepsFn, the
/// loop over them.
[[nodiscard]] std::unique_ptr<llvm::Module> build_steps(llvm::LLVMContext& context, const lower::LoweredSystem& lowered,
                                                        Lines lines = Lines::No);
[[nodiscard]] std::string step_name(std::size_t shape);
inline const std::string kStepLoopName = "bip_steps";
[[nodiscard]] bool has_step_loop(const lower::LoweredSystem& lowered, Lines lines);

}  // namespace bip::jit
