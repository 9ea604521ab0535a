// The target machine (this host), and the IR passes that run before code generation. Internal to jit/.
#pragma once
#include <llvm/ExecutionEngine/Orc/JITTargetMachineBuilder.h>
#include <llvm/IR/Module.h>
#include <llvm/Target/TargetMachine.h>

#include <memory>
#include <string>

#include "compiler/base/result.hpp"
#include "compiler/jit/opt_level.hpp"

namespace bip::jit {

/// This host: its CPU and features; no floating-point contraction, so that results are those of plain IEEE doubles.
[[nodiscard]] Result<llvm::orc::JITTargetMachineBuilder> host_target(OptLevel level);
[[nodiscard]] Result<std::unique_ptr<llvm::TargetMachine>> make_machine(llvm::orc::JITTargetMachineBuilder builder);

/// O2: LLVM's default pipeline. O0: nothing.
void optimize(llvm::Module& module, llvm::TargetMachine& machine, OptLevel level);

/// The text of an llvm::Error, consumed.
[[nodiscard]] std::string text_of(llvm::Error error);

}  // namespace bip::jit
