// Prints the units as LLVM IR or as assembly of this machine, in one module.
#include <llvm/ADT/SmallString.h>
#include <llvm/IR/LegacyPassManager.h>
#include <llvm/IR/Verifier.h>
#include <llvm/Support/raw_ostream.h>

#include "compiler/jit/codegen.hpp"
#include "compiler/jit/jit.hpp"
#include "compiler/jit/target.hpp"

namespace bip::jit {
namespace {

/// What both need: the module after its passes, and the machine.
struct Emission {
  std::unique_ptr<llvm::LLVMContext> context;
  std::unique_ptr<llvm::Module> module;
  std::unique_ptr<llvm::TargetMachine> machine;
};

Result<Emission> make_emission(const lower::LoweredSystem& lowered, OptLevel level) {
  Result<llvm::orc::JITTargetMachineBuilder> target = host_target(level);
  if (!target) return Failure{target.error()};
  Result<std::unique_ptr<llvm::TargetMachine>> machine = make_machine(*target);
  if (!machine) return Failure{machine.error()};
  Emission out;
  out.machine = std::move(*machine);
  out.context = std::make_unique<llvm::LLVMContext>();
  out.module = build_module(*out.context, lowered, 0, lowered.units.size());
  out.module->setModuleIdentifier("units");
  out.module->setDataLayout(out.machine->createDataLayout());
  out.module->setTargetTriple(out.machine->getTargetTriple().str());
  std::string problem;
  llvm::raw_string_ostream stream(problem);
  if (llvm::verifyModule(*out.module, &stream)) return Failure{"our LLVM IR is not well-formed: " + problem};
  optimize(*out.module, *out.machine, level);
  return out;
}

}  // namespace

Result<std::string> emit_llvm(const lower::LoweredSystem& lowered, OptLevel level) {
  Result<Emission> emission = make_emission(lowered, level);
  if (!emission) return Failure{emission.error()};
  std::string text;
  llvm::raw_string_ostream stream(text);
  emission->module->print(stream, nullptr);
  return text;
}

Result<std::string> emit_asm(const lower::LoweredSystem& lowered, OptLevel level) {
  Result<Emission> emission = make_emission(lowered, level);
  if (!emission) return Failure{emission.error()};
  llvm::SmallString<0> text;
  llvm::raw_svector_ostream stream(text);
  llvm::legacy::PassManager passes;
  if (emission->machine->addPassesToEmitFile(passes, stream, nullptr, llvm::CodeGenFileType::AssemblyFile))
    return Failure{"this machine's code generator writes no assembly"};
  passes.run(*emission->module);
  return std::string(text.str());
}

}  // namespace bip::jit
