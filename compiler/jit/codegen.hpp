// LLVM IR for code units. Internal to jit/; includes only the IR headers of LLVM.
#pragma once
#include <llvm/IR/Module.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "compiler/lower/lower.hpp"

namespace bip::jit {

class DebugInfo;

/// C++ functions and data of the process, declared by name; a number follows some: row of functions, of FFI types.
inline const std::string kFunctionName = "bip_call_", kCopyName = "bip_copy_", kFfiContextName = "bip_ffi_context",
                         kResultName = "bip_result", kLoweredName = "bip_lowered", kCodesName = "bip_codes",
                         kDrawName = "bip_draw", kOperandTableName = "bip_operand_table";

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

/// A module with a rt::StepFn for each shape of lowered.steps, named step_name(shape), and the loops over them.
[[nodiscard]] std::unique_ptr<llvm::Module> build_steps(llvm::LLVMContext& context, const lower::LoweredSystem& lowered,
                                                        Lines lines = Lines::No);
[[nodiscard]] std::string step_name(std::size_t shape);
/// Drawn and Inner are rt::StepsFn, of the core's arrays and of those in inner order; Ordered is a rt::OrderedStepsFn.
enum class StepLoop : std::uint8_t { Drawn, Inner, Ordered };
[[nodiscard]] std::string loop_name(StepLoop loop);
/// Returns the loops that the module of the system has.
[[nodiscard]] std::vector<StepLoop> step_loops(const lower::LoweredSystem& lowered, Lines lines);

}  // namespace bip::jit
