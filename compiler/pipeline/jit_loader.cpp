// Finds and opens libbipc_jit.so: see jit_loader.hpp.
#include "compiler/pipeline/jit_loader.hpp"

#include <dlfcn.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "bip/process.hpp"
#include "compiler/jit/plugin_abi.hpp"
#include "compiler/pipeline/parts.hpp"

namespace bip::pipeline {
namespace {

constexpr const char* kFileName = "libbipc_jit.so";

std::filesystem::path find_plugin() {
  std::error_code error;
  for (const std::filesystem::path& path : places_of_part(kFileName))
    if (std::filesystem::exists(path, error)) return path;
  return {};
}

// While it lives, abort() ends the process as a lack of resources does. The constructors of LLVM's globals run in
// dlopen, before LLVM can be given a handler (see jit.cpp); what makes them abort, after a report of their own, is that
// memory is missing.
class AbortIsLackOfMemory {
 public:
  AbortIsLackOfMemory() {
    struct sigaction action {};
    action.sa_handler = [](int) { std::_Exit(kNoResources); };
    ::sigaction(SIGABRT, &action, &before_);
  }
  ~AbortIsLackOfMemory() { ::sigaction(SIGABRT, &before_, nullptr); }
  AbortIsLackOfMemory(const AbortIsLackOfMemory&) = delete;
  AbortIsLackOfMemory& operator=(const AbortIsLackOfMemory&) = delete;

 private:
  struct sigaction before_ {};
};

void* open_plugin(const std::filesystem::path& path) {
  const AbortIsLackOfMemory aborts_by_llvm;
  // Local: LLVM's symbols must not meet those of the program.
  return dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
}

template <class F>
F* function_of(void* library, const char* name) {
  return reinterpret_cast<F*>(dlsym(library, name));
}

}  // namespace

std::string find_jit_plugin() { return find_plugin().string(); }

Result<JitPlugin> load_jit() {
  const std::filesystem::path path = find_plugin();
  if (path.empty())
    return Failure{std::string("this bipc has no JIT: `") + kFileName +
                   "` is not beside it; `--backend=interp` works without"};
  void* library = open_plugin(path);
  if (library == nullptr) {
    const char* reason = dlerror();
    return Failure{std::string("the JIT does not load: ") + (reason != nullptr ? reason : "unknown reason")};
  }
  auto* abi = function_of<jit::AbiFn>(library, jit::kAbiName);
  JitPlugin plugin;
  plugin.compile_ = function_of<jit::CompileFn>(library, jit::kCompileName);
  plugin.destroy_ = function_of<jit::DestroyFn>(library, jit::kDestroyName);
  plugin.emit_ = function_of<jit::EmitFn>(library, jit::kEmitName);
  if (abi == nullptr || plugin.compile_ == nullptr || plugin.destroy_ == nullptr || plugin.emit_ == nullptr ||
      abi() != jit::kPluginAbi)
    return Failure{"`" + path.string() + "` belongs to another build of bipc; build both together"};
  return plugin;
}

Result<JitCode> JitPlugin::compile(const lower::LoweredSystem& lowered, const jit::JitOptions& options,
                                   jit::MadeCode& made) const {
  std::string error;
  JitCode code(compile_(&lowered, &options, &made, &error), JitDeleter{destroy_});
  if (!code) return Failure{std::move(error)};
  return code;
}

Result<std::string> JitPlugin::emit(const lower::LoweredSystem& lowered, jit::OptLevel level, jit::Listing kind) const {
  std::string text;
  if (!emit_(&lowered, level, kind, &text)) return Failure{std::move(text)};
  return text;
}
Result<std::string> JitPlugin::emit_llvm(const lower::LoweredSystem& lowered, jit::OptLevel level) const {
  return emit(lowered, level, jit::Listing::Llvm);
}
Result<std::string> JitPlugin::emit_asm(const lower::LoweredSystem& lowered, jit::OptLevel level) const {
  return emit(lowered, level, jit::Listing::Asm);
}

}  // namespace bip::pipeline
