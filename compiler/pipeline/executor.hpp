// Selects an executor: fills the image's code from the interpreter or the JIT.
#pragma once
#include <memory>

#include "compiler/pipeline/jit_loader.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/pipeline/tiers.hpp"
#include "compiler/interp/interp.hpp"

namespace bip::pipeline {

/// Up to this many guards, actions and transfers `run` takes -O2 by itself: about 0.1 s (LLVM 19: 3 ms a function).
inline constexpr std::size_t kMaxUnitsForO2 = 32;

[[nodiscard]] jit::OptLevel opt_level(const lower::LoweredSystem& lowered, Optimisation optimisation);

/// Do gdb and perf see machine code and its lines?
enum class ForDebuggers : std::uint8_t { No, Yes };

/// Fresh: nothing from the cache is executed, so that the folder is not in the trusted base of a verdict.
enum class MachineCode : std::uint8_t { Cached, Fresh };

/// Owns what the image's code pointers need; keep alive as long as the image runs, and not longer than the compilation.
class Executor {
 public:
  explicit Executor(MachineCode code = MachineCode::Cached) : code_(code) {}
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;
  ~Executor();
  /// False if the back end failed; c.diags says why.
  [[nodiscard]] bool prepare(Compilation& c, Backend backend, Optimisation optimisation,
                             ForDebuggers for_debuggers = ForDebuggers::No);
  /// The interpreter at once; machine code follows from another thread while the image runs.
  [[nodiscard]] bool prepare_tiered(Compilation& c);
  /// Of a run that was prepared so; else null.
  [[nodiscard]] rt::NewCode* new_code() { return tiers_ ? &tiers_->new_code() : nullptr; }
  /// After the run: what the JIT made, and how long that took; nothing if there was none.
  [[nodiscard]] std::string summary();

 private:
  [[nodiscard]] CacheOptions cache_of(const Compilation& c) const;

  MachineCode code_;
  lower::LoweredSystem* lowered_ = nullptr;  // the results of its calls are objects that C++ made
  std::unique_ptr<interp::Interpreter> interpreter_;
  JitCode jit_;
  jit::MadeCode made_;
  double seconds_ = 0;
  std::unique_ptr<Tiers> tiers_;  // its thread ends before the rest goes
};

}  // namespace bip::pipeline
