// Compiles units to machine code in this process, with LLVM's ORC.
//
// A module has kUnitsPerModule units (one unit per module costs six times as much; all units in one module delay the
// first result). Each module is compiled and looked up before the next is built, so memory is bounded by one module
// plus the code. Each module has its own LLVM context, which is destroyed with it. The object code of a module is
// looked up in the cache by the hash of its unoptimised IR, of the processor and of this library; passes run only for
// modules that are not in the cache.
#include "compiler/jit/jit.hpp"

#include <llvm/Bitcode/BitcodeWriter.h>
#include <llvm/Config/llvm-config.h>
#include <llvm/ExecutionEngine/Orc/CompileUtils.h>
#include <llvm/ExecutionEngine/Orc/LLJIT.h>
#include <llvm/Support/ErrorHandling.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <optional>
#include <string_view>

#include "bip/prng.hpp"
#include "bip/process.hpp"
#include "compiler/base/build_id.hpp"
#include "compiler/base/content_cache.hpp"
#include "compiler/base/content_hash.hpp"
#include "compiler/jit/codegen.hpp"
#include "compiler/jit/debug_info.hpp"
#include "compiler/jit/target.hpp"
#include "compiler/jit/watchers.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::jit {
namespace {

constexpr std::size_t kUnitsPerModule = 256;

// The library that holds this function, as built: another build's passes may be others.
std::string own_build() { return build_id_of(reinterpret_cast<const void*>(&own_build)); }

// For the loop over steps.
std::uint64_t draw(rt::Prng* prng, std::uint64_t below) { return prng->below(below); }

// For calls that give a value of an FFI type.
rt::Cell* result_cell(lower::LoweredSystem* lowered, std::uint32_t call, std::uint32_t type) {
  return lowered->results.cell(call, lowered->ffi_types[type]);
}

llvm::Error stopped() { return llvm::createStringError(llvm::inconvertibleErrorCode(), "stopped"); }

// One compilation, module by module. Its product is the engine, which owns the code.
struct Compiler {
  Compiler(const lower::LoweredSystem& l, const JitOptions& o, MadeCode& m)
      : lowered(l), options(o), made(m), cache(ContentKind::Object, o.cache_folder, o.cache_bytes) {}

  const lower::LoweredSystem& lowered;
  const JitOptions& options;
  MadeCode& made;
  ContentCache cache;
  std::unique_ptr<llvm::orc::LLJIT> engine;
  std::unique_ptr<llvm::TargetMachine> machine;
  std::string origin;  // what all objects depend on

  /// Gives the FFI of the system its names.
  llvm::Error add_ffi() {
    llvm::orc::SymbolMap symbols;
    const auto add = [&](const std::string& name, const void* address) {
      if (address == nullptr) return;
      symbols[engine->mangleAndIntern(name)] = {llvm::orc::ExecutorAddr::fromPtr(address),
                                                llvm::JITSymbolFlags::Exported};
    };
    const auto number = [](std::size_t k) { return std::to_string(k); };
    add(kCodesName, lowered.codes.data());
    add(kDrawName, reinterpret_cast<const void*>(&draw));
    add(kOperandTableName, lowered.steps.table.numbers.data());
    add(kFfiContextName, static_cast<const rt::FfiContext*>(&lowered.ffi));
    if (lowered.image.ffi != nullptr) {
      add(kLoweredName, &lowered);
      add(kResultName, reinterpret_cast<const void*>(&result_cell));
    }
    for (std::size_t k = 0; k < lowered.functions.size(); ++k)
      add(kFunctionName + number(k), reinterpret_cast<const void*>(lowered.functions[k]));
    for (std::size_t k = 0; k < lowered.ffi_types.size(); ++k)
      add(kCopyName + number(k), reinterpret_cast<const void*>(lowered.ffi_types[k].copy));
    return engine->getMainJITDylib().define(llvm::orc::absoluteSymbols(std::move(symbols)));
  }

  /// gdb and perf: names and lines of all functions.
  llvm::Error add_watchers() {
    std::map<std::string, std::string> labels;
    const auto add = [&](const std::string& symbol, const Place& place) {
      const auto& files = lowered.image.files;
      const std::string file = place.loc.file < files.size ? files[place.loc.file] : "";
      labels[symbol] = place.name + " [" + file + ":" + std::to_string(place.loc.line) + "]";
    };
    for (std::size_t k = 0; k < lowered.units.size(); ++k) add(lowered.units[k].name, unit_place(lowered, k));
    const std::vector<Place> places = shape_places(lowered);
    for (std::size_t k = 0; k < places.size(); ++k) add(step_name(k), places[k]);
    return let_watch(*engine, std::move(labels));
  }

  std::string name_of(const llvm::Module& module) const {
    llvm::SmallVector<char, 0> bitcode;
    llvm::raw_svector_ostream stream(bitcode);
    llvm::WriteBitcodeToFile(module, stream);
    return content_hash({origin, {bitcode.data(), bitcode.size()}});
  }

  llvm::Expected<std::unique_ptr<llvm::MemoryBuffer>> object_of(llvm::Module& module) {
    const std::string name = cache.is_on() ? name_of(module) : std::string();
    if (cache.is_on()) {
      if (const std::optional<std::string> bytes = cache.load(name)) {
        ++made.from_cache;
        return llvm::MemoryBuffer::getMemBufferCopy(*bytes, module.getName());
      }
    }
    optimize(module, *machine, options.level);
    llvm::orc::SimpleCompiler compiler(*machine);
    auto object = compiler(module);
    if (object) cache.store(name, {(*object)->getBufferStart(), (*object)->getBufferSize()});
    return object;
  }

  /// Compiles a module and looks its functions up, all names at once: one trip through the session.
  llvm::Expected<std::vector<llvm::orc::ExecutorAddr>> add_module(std::unique_ptr<llvm::Module> module,
                                                                  const std::vector<std::string>& functions) {
    module->setDataLayout(engine->getDataLayout());
    module->setTargetTriple(engine->getTargetTriple().str());
    ++made.modules;
    auto object = object_of(*module);
    if (!object) return object.takeError();
    if (llvm::Error error = engine->addObjectFile(std::move(*object))) return error;
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

  [[nodiscard]] Lines lines() const { return options.for_debuggers ? Lines::Yes : Lines::No; }

  llvm::Error add_units(std::size_t first, std::size_t count) {
    llvm::LLVMContext context;
    std::unique_ptr<llvm::Module> module = build_module(context, lowered, first, count, lines());
    std::vector<std::string> names;
    for (std::size_t k = 0; k < count; ++k) names.push_back(lowered.units[first + k].name);
    auto found = add_module(std::move(module), names);
    if (!found) return found.takeError();
    BIP_ASSERT(found->size() == count && made.codes.size() == first, "{} functions from unit {} on", found->size(),
               made.codes.size());
    for (const llvm::orc::ExecutorAddr& address : *found)
      made.codes.push_back({.fn = address.toPtr<rt::CodeFn>(), .context = nullptr});
    return llvm::Error::success();
  }

  llvm::Error add_steps() {
    if (lowered.steps.shapes.empty()) return llvm::Error::success();
    llvm::LLVMContext context;
    std::unique_ptr<llvm::Module> module = build_steps(context, lowered, lines());
    std::vector<std::string> names;
    for (std::size_t k = 0; k < lowered.steps.shapes.size(); ++k) names.push_back(step_name(k));
    const std::vector<StepLoop> loops = step_loops(lowered, lines());
    for (const StepLoop loop : loops) names.push_back(loop_name(loop));
    auto found = add_module(std::move(module), names);
    if (!found) return found.takeError();
    for (std::size_t k = 0; k < loops.size(); ++k) {
      const llvm::orc::ExecutorAddr address = (*found)[lowered.steps.shapes.size() + k];
      switch (loops[k]) {
        case StepLoop::Drawn: made.steps_fn = address.toPtr<rt::StepsFn>(); break;
        case StepLoop::Inner: made.inner_steps_fn = address.toPtr<rt::StepsFn>(); break;
        case StepLoop::Ordered: made.ordered_steps_fn = address.toPtr<rt::OrderedStepsFn>(); break;
      }
    }
    found->resize(lowered.steps.shapes.size());
    BIP_ASSERT(found->size() == lowered.steps.shapes.size(), "{} functions of {} shapes", found->size(),
               lowered.steps.shapes.size());
    for (const llvm::orc::ExecutorAddr& address : *found) made.step_fns.push_back(address.toPtr<rt::StepFn>());
    return llvm::Error::success();
  }

  [[nodiscard]] bool goes_on() const { return !options.goes_on || options.goes_on(); }
};

// LLVM is compiled without exceptions: one that passes through it leaves locks and half-made objects behind. So a lack
// of memory ends the process here, as it ends a command elsewhere (bip/process.hpp).
[[noreturn]] void end_without_memory() {
  constexpr std::string_view kText = "error: out of memory\n";
  if (::write(STDERR_FILENO, kText.data(), kText.size()) < 0) std::_Exit(kNoResources);
  std::_Exit(kNoResources);
}

class EndWithoutMemory {
 public:
  EndWithoutMemory() : before_(std::set_new_handler(end_without_memory)) {
    // Of what LLVM allocates by malloc.
    static const bool is_installed = [] {
      llvm::install_bad_alloc_error_handler([](void*, const char*, bool) { end_without_memory(); });
      return true;
    }();
    (void)is_installed;
  }
  ~EndWithoutMemory() { std::set_new_handler(before_); }
  EndWithoutMemory(const EndWithoutMemory&) = delete;
  EndWithoutMemory& operator=(const EndWithoutMemory&) = delete;

 private:
  std::new_handler before_;
};

}  // namespace

struct Jit::Impl {
  std::unique_ptr<llvm::orc::LLJIT> engine;
};

Jit::Jit() : impl_(std::make_unique<Impl>()) {}
Jit::~Jit() = default;

Result<std::unique_ptr<Jit>> Jit::compile(const lower::LoweredSystem& lowered, const JitOptions& options,
                                          MadeCode& made) {
  const EndWithoutMemory end_without_memory_here;
  Result<llvm::orc::JITTargetMachineBuilder> target = host_target(options.level);
  if (!target) return Failure{target.error()};
  // As the linker wants it.
  (*target).setRelocationModel(llvm::Reloc::PIC_);
  (*target).setCodeModel(llvm::CodeModel::Small);
  Compiler compiler(lowered, options, made);
  Result<std::unique_ptr<llvm::TargetMachine>> machine = make_machine(*target);
  if (!machine) return Failure{machine.error()};
  compiler.machine = std::move(*machine);
  compiler.origin = content_hash({options.version, own_build(), LLVM_VERSION_STRING,
                                  options.level == OptLevel::O0 ? "0" : "2", compiler.machine->getTargetTriple().str(),
                                  compiler.machine->getTargetCPU(), compiler.machine->getTargetFeatureString()});
  // Our code has no initialisers, no thread-locals and calls only what add_ffi names: no platform, no look into the
  // process.
  auto engine = llvm::orc::LLJITBuilder()
                    .setJITTargetMachineBuilder(std::move(*target))
                    .setPlatformSetUp(llvm::orc::setUpInactivePlatform)
                    .create();
  if (!engine) return Failure{"the JIT does not start: " + text_of(engine.takeError())};
  compiler.engine = std::move(*engine);
  if (llvm::Error error = compiler.add_ffi())
    return Failure{"the JIT does not take the C++ functions: " + text_of(std::move(error))};
  if (options.for_debuggers) {
    if (llvm::Error error = compiler.add_watchers())
      return Failure{"the JIT cannot be watched: " + text_of(std::move(error))};
  }
  for (std::size_t first = 0; first < lowered.units.size(); first += kUnitsPerModule) {
    const std::size_t count = std::min(kUnitsPerModule, lowered.units.size() - first);
    if (llvm::Error error = compiler.goes_on() ? compiler.add_units(first, count) : stopped())
      return Failure{"the JIT fails on `" + lowered.units[first].name +
                     "` and those after it: " + text_of(std::move(error))};
  }
  if (llvm::Error error = compiler.goes_on() ? compiler.add_steps() : stopped())
    return Failure{"the JIT fails on whole steps: " + text_of(std::move(error))};
  BIP_ASSERT(made.codes.size() == lowered.units.size() && made.step_fns.size() == lowered.steps.shapes.size(),
             "{} codes of {} units", made.codes.size(), lowered.units.size());
  made.broken_files = compiler.cache.broken();
  std::unique_ptr<Jit> jit(new Jit());
  jit->impl_->engine = std::move(compiler.engine);
  return jit;
}

Result<std::unique_ptr<Jit>> Jit::compile(lower::LoweredSystem& lowered, OptLevel level) {
  MadeCode made;
  Result<std::unique_ptr<Jit>> jit = compile(lowered, {.level = level}, made);
  if (jit) install(lowered, made);
  return jit;
}

}  // namespace bip::jit
