// The choice of an executor: fills the image's code from the interpreter or the JIT.
#pragma once
#include <memory>

#include "compiler/driver/jit_loader.hpp"
#include "compiler/driver/pipeline.hpp"
#include "compiler/interp/interp.hpp"

namespace bip::driver {

/// Up to this many guards, actions and transfers `run` takes -O2 by itself: about 0.1 s (LLVM 19: 3 ms a function).
inline constexpr std::size_t kMaxUnitsForO2 = 32;

[[nodiscard]] jit::OptLevel opt_level(const lower::LoweredSystem& lowered, Optimisation optimisation);

/// Do gdb and perf see machine code and its lines?
enum class ForDebuggers : std::uint8_t { No, Yes };

/// Owns what the image's code pointers need; keep alive as long as the image runs, and not longer than the compilation.
class Executor {
 public:
  Executor() = default;
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;
  ~Executor();
  /// False if the back end failed; c.diags says why.
  [[nodiscard]] bool prepare(Compilation& c, Backend backend, Optimisation optimisation, ForDebuggers for_debuggers = ForDebuggers::No);
  /// What the JIT made, and how long that took; nothing if there was none.
  [[nodiscard]] std::string summary() const;

 private:
  lower::LoweredSystem* lowered_ = nullptr;  // its temporaries are objects that C++ made
  std::unique_ptr<interp::Interpreter> interpreter_;
  JitCode jit_;
  jit::MadeCode made_;
  double seconds_ = 0;
};

}  // namespace bip::driver
