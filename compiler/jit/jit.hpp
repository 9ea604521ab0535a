// Native code for guards, actions and transfers with LLVM ORC. The only folder that includes LLVM.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/jit/opt_level.hpp"
#include "compiler/lower/lower.hpp"

namespace bip::jit {

struct JitOptions {
  OptLevel level = OptLevel::O2;
  std::string cache_folder = {};                         // where machine code is kept for the next time; empty: nowhere
  std::uint64_t cache_bytes = std::uint64_t{256} << 20;  // at most so much of it
  std::string version = {};                              // of the program: its code is not another's
  bool for_debuggers = false;                            // gdb and perf see the code and its lines in the model
  std::function<bool()> goes_on = {};                    // asked before each module; false: the compilation fails
};

/// What a compilation makes: a row a unit, a function a shape, a loop over steps.
struct MadeCode {
  std::vector<rt::Code> codes;
  std::vector<rt::StepFn> step_fns;
  // The loops over them, if there are any.
  rt::StepsFn steps_fn = nullptr, inner_steps_fn = nullptr;
  rt::OrderedStepsFn ordered_steps_fn = nullptr;
  std::size_t modules = 0, from_cache = 0;
  std::vector<std::string> broken_files;  // of the cache; made anew
};
/// Makes the image run this code, which must outlive the image. Requires that no step is under way. A Core that is
/// already linked keeps the old code until its take_new_code is called.
inline void install(lower::LoweredSystem& lowered, const MadeCode& made) {
  for (std::size_t k = 0; k < made.codes.size(); ++k) lowered.codes[k] = made.codes[k];
  lowered.step_fns = made.step_fns;
  lowered.image.step_fns = {lowered.step_fns.data(), static_cast<std::uint32_t>(lowered.step_fns.size())};
  lowered.image.steps_fn = made.steps_fn;
  lowered.image.inner_steps.steps_fn = made.inner_steps_fn;
  lowered.image.ordered_steps_fn = made.ordered_steps_fn;
}

/// Owns the machine code; keep alive as long as the image runs.
class Jit {
 public:
  /// Compiles all units; a function for each shape of lowered.steps, if there are any. Reads only, but for `made`.
  static Result<std::unique_ptr<Jit>> compile(const lower::LoweredSystem& lowered, const JitOptions& options,
                                              MadeCode& made);
  /// The same, installed.
  static Result<std::unique_ptr<Jit>> compile(lower::LoweredSystem& lowered, OptLevel level);
  ~Jit();

 private:
  Jit();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The LLVM IR (textual) or the assembly of all units, for --emit=llvm|asm.
[[nodiscard]] Result<std::string> emit_llvm(const lower::LoweredSystem& lowered, OptLevel level);
[[nodiscard]] Result<std::string> emit_asm(const lower::LoweredSystem& lowered, OptLevel level);

}  // namespace bip::jit
