// Units to machine code in this process, with LLVM's ORC.
//
// Units go in modules of kUnitsPerModule (one a module costs six times as much, all in one makes passes and linking
// slow to start), each compiled and looked up before the next is built, so that memory stays that of one module plus the
// code. A module has a context of its own: what a pass interns dies with it.
#include "compiler/jit/jit.hpp"

#include <llvm/ExecutionEngine/Orc/LLJIT.h>

#include <algorithm>

#include "compiler/jit/codegen.hpp"
#include "compiler/jit/target.hpp"

namespace bip::jit {
namespace {

constexpr std::size_t kUnitsPerModule = 256;

}  // namespace

struct Jit::Impl {
  std::unique_ptr<llvm::orc::LLJIT> engine;
  std::unique_ptr<llvm::TargetMachine> machine;

  /// Gives the C++ side of the system its names.
  llvm::Error add_outside(lower::LoweredSystem& lowered) {
    llvm::orc::SymbolMap symbols;
    const auto add = [&](const std::string& name, const void* address) {
      if (address == nullptr) return;
      symbols[engine->mangleAndIntern(name)] = {llvm::orc::ExecutorAddr::fromPtr(address), llvm::JITSymbolFlags::Exported};
    };
    const auto number = [](std::size_t k) { return std::to_string(k); };
    add(kCodesName, lowered.codes.data());
    if (lowered.image.outside != nullptr) add(kOutsideName, &lowered.outside);
    for (std::size_t k = 0; k < lowered.functions.size(); ++k) add(kFunctionName + number(k), reinterpret_cast<const void*>(lowered.functions[k]));
    for (std::size_t k = 0; k < lowered.extern_types.size(); ++k) add(kCopyName + number(k), reinterpret_cast<const void*>(lowered.extern_types[k].copy));
    for (std::size_t k = 0; k < lowered.temporaries.size(); ++k) {
      if (lowered.temporaries[k].bits != 0) add(kTemporaryName + number(k), &lowered.temporaries[k]);
    }
    return engine->getMainJITDylib().define(llvm::orc::absoluteSymbols(std::move(symbols)));
  }

  /// Compiles a module and looks its functions up, all names at once: one trip through the session.
  llvm::Expected<std::vector<llvm::orc::ExecutorAddr>> add_module(std::unique_ptr<llvm::LLVMContext> context, std::unique_ptr<llvm::Module> module,
                                                                   OptLevel level, const std::vector<std::string>& functions) {
    module->setDataLayout(engine->getDataLayout());
    module->setTargetTriple(engine->getTargetTriple().str());
    optimize(*module, *machine, level);
    if (llvm::Error error =
            engine->addIRModule(llvm::orc::ThreadSafeModule(std::move(module), std::move(context))))
      return error;
    llvm::orc::ExecutionSession& session = engine->getExecutionSession();
    std::vector<llvm::orc::SymbolStringPtr> names;
    llvm::orc::SymbolLookupSet wanted;
    for (const std::string& function : functions) {
      names.push_back(engine->mangleAndIntern(function));
      wanted.add(names.back());
    }
    auto found = session.lookup(llvm::orc::makeJITDylibSearchOrder(&engine->getMainJITDylib()), std::move(wanted));
    if (!found) return found.takeError();
    std::vector<llvm::orc::ExecutorAddr> addresses;
    for (const llvm::orc::SymbolStringPtr& name : names) addresses.push_back((*found)[name].getAddress());
    return addresses;
  }

  llvm::Error add_units(lower::LoweredSystem& lowered, OptLevel level, std::size_t first, std::size_t count) {
    auto context = std::make_unique<llvm::LLVMContext>();
    std::unique_ptr<llvm::Module> module = build_module(*context, lowered, first, count);
    std::vector<std::string> names;
    for (std::size_t k = 0; k < count; ++k) names.push_back(lowered.units[first + k].name);
    auto found = add_module(std::move(context), std::move(module), level, names);
    if (!found) return found.takeError();
    for (std::size_t k = 0; k < count; ++k) lowered.codes[first + k] = {.fn = (*found)[k].toPtr<rt::CodeFn>(), .context = nullptr};
    return llvm::Error::success();
  }

  llvm::Error add_steps(lower::LoweredSystem& lowered, OptLevel level) {
    lowered.step_fns.clear();
    if (!lowered.steps.shapes.empty()) {
      auto context = std::make_unique<llvm::LLVMContext>();
      std::unique_ptr<llvm::Module> module = build_steps(*context, lowered);
      std::vector<std::string> names;
      for (std::size_t k = 0; k < lowered.steps.shapes.size(); ++k) names.push_back(step_name(k));
      auto found = add_module(std::move(context), std::move(module), level, names);
      if (!found) return found.takeError();
      for (const llvm::orc::ExecutorAddr& address : *found) lowered.step_fns.push_back(address.toPtr<rt::StepFn>());
    }
    lowered.image.step_fns = {lowered.step_fns.data(), static_cast<std::uint32_t>(lowered.step_fns.size())};
    return llvm::Error::success();
  }
};

Jit::Jit() : impl_(std::make_unique<Impl>()) {}
Jit::~Jit() = default;

Result<std::unique_ptr<Jit>> Jit::compile(lower::LoweredSystem& lowered, OptLevel level) {
  Result<llvm::orc::JITTargetMachineBuilder> target = host_target(level);
  if (!target) return Failure{target.error()};
  std::unique_ptr<Jit> jit(new Jit());
  Result<std::unique_ptr<llvm::TargetMachine>> machine = make_machine(*target);
  if (!machine) return Failure{machine.error()};
  jit->impl_->machine = std::move(*machine);
  // Our code has no initialisers, no thread-locals and calls only what add_outside names: no platform, no look into the process.
  auto engine = llvm::orc::LLJITBuilder()
                    .setJITTargetMachineBuilder(std::move(*target))
                    .setPlatformSetUp(llvm::orc::setUpInactivePlatform)
                    .create();
  if (!engine) return Failure{"the JIT does not start: " + text_of(engine.takeError())};
  jit->impl_->engine = std::move(*engine);
  if (llvm::Error error = jit->impl_->add_outside(lowered)) return Failure{"the JIT does not take the C++ functions: " + text_of(std::move(error))};
  for (std::size_t first = 0; first < lowered.units.size(); first += kUnitsPerModule) {
    const std::size_t count = std::min(kUnitsPerModule, lowered.units.size() - first);
    if (llvm::Error error = jit->impl_->add_units(lowered, level, first, count))
      return Failure{"the JIT fails on `" + lowered.units[first].name + "` and those after it: " + text_of(std::move(error))};
  }
  if (llvm::Error error = jit->impl_->add_steps(lowered, level)) return Failure{"the JIT fails on whole steps: " + text_of(std::move(error))};
  return jit;
}

}  // namespace bip::jit
