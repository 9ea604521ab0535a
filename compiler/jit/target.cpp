// Target machine of this host and the optimisation pipeline: see target.hpp.
#include "compiler/jit/target.hpp"

#include <llvm/Passes/PassBuilder.h>
#include <llvm/Passes/StandardInstrumentations.h>
#include <llvm/Support/TargetSelect.h>

namespace bip::jit {

Result<llvm::orc::JITTargetMachineBuilder> host_target(OptLevel level) {
  // LLVM's registry of targets is the one process-wide table we cannot do without; registering twice is harmless.
  llvm::InitializeNativeTarget();
  llvm::InitializeNativeTargetAsmPrinter();
  auto builder = llvm::orc::JITTargetMachineBuilder::detectHost();
  if (!builder) return Failure{"no code generator for this machine: " + text_of(builder.takeError())};
  builder->setCodeGenOptLevel(level == OptLevel::O0 ? llvm::CodeGenOptLevel::None : llvm::CodeGenOptLevel::Default);
  builder->getOptions().AllowFPOpFusion = llvm::FPOpFusion::Strict;
  return std::move(*builder);
}

Result<std::unique_ptr<llvm::TargetMachine>> make_machine(llvm::orc::JITTargetMachineBuilder builder) {
  auto machine = builder.createTargetMachine();
  if (!machine) return Failure{"no code generator for this machine: " + text_of(machine.takeError())};
  return std::move(*machine);
}

void optimize(llvm::Module& module, llvm::TargetMachine& machine, OptLevel level) {
  if (level == OptLevel::O0) return;
  llvm::LoopAnalysisManager loops;
  llvm::FunctionAnalysisManager functions;
  llvm::CGSCCAnalysisManager sccs;
  llvm::ModuleAnalysisManager modules;
  // Without it the passes do not see `optnone`, by which code generation marks the units that they would choke on.
  llvm::PassInstrumentationCallbacks callbacks;
  llvm::OptNoneInstrumentation skip_optnone(false);
  skip_optnone.registerCallbacks(callbacks);
  llvm::PassBuilder passes(&machine, llvm::PipelineTuningOptions(), std::nullopt, &callbacks);
  passes.registerModuleAnalyses(modules);
  passes.registerCGSCCAnalyses(sccs);
  passes.registerFunctionAnalyses(functions);
  passes.registerLoopAnalyses(loops);
  passes.crossRegisterProxies(loops, functions, sccs, modules);
  passes.buildPerModuleDefaultPipeline(llvm::OptimizationLevel::O2).run(module, modules);
}

std::string text_of(llvm::Error error) { return llvm::toString(std::move(error)); }

}  // namespace bip::jit
