// Loads the JIT when a command needs it, so that `bipc check` does not pay for libLLVM.
//
// The plug-in libbipc_jit.so is searched beside the executable, then in ../lib/bipc (an installed tree). Once loaded it
// remains for the life of the process, because LLVM cannot be unloaded safely.
#pragma once
#include <memory>
#include <string>

#include "compiler/jit/plugin.hpp"

namespace bip::pipeline {

/// TransitionSystem code that must live as long as the image runs.
struct JitDeleter {
  jit::DestroyFn* destroy = nullptr;
  void operator()(jit::Jit* jit) const { destroy(jit); }
};
using JitCode = std::unique_ptr<jit::Jit, JitDeleter>;

/// The loaded plug-in: a handle of functions, cheap to copy.
class JitPlugin {
 public:
  /// Compiles all units and steps.
  [[nodiscard]] Result<JitCode> compile(const lower::LoweredSystem& lowered, const jit::JitOptions& options,
                                        jit::MadeCode& made) const;
  [[nodiscard]] Result<std::string> emit_llvm(const lower::LoweredSystem& lowered, jit::OptLevel level) const;
  [[nodiscard]] Result<std::string> emit_asm(const lower::LoweredSystem& lowered, jit::OptLevel level) const;

 private:
  friend Result<JitPlugin> load_jit();
  [[nodiscard]] Result<std::string> emit(const lower::LoweredSystem& lowered, jit::OptLevel level,
                                         jit::Listing kind) const;

  jit::CompileFn* compile_ = nullptr;
  jit::DestroyFn* destroy_ = nullptr;
  jit::EmitFn* emit_ = nullptr;
};

/// The plug-in's path, empty if there is none.
[[nodiscard]] std::string find_jit_plugin();

/// Fails with a reason and what to do instead if the plug-in is not there, does not load, or is of another build.
[[nodiscard]] Result<JitPlugin> load_jit();

}  // namespace bip::pipeline
