// Native code for guards, actions and transfers with LLVM ORC. The only folder that knows LLVM.
#pragma once
#include <memory>
#include <string>

#include "compiler/base/result.hpp"
#include "compiler/lower/lower.hpp"

namespace bip::jit {

enum class OptLevel : std::uint8_t { O0, O2 };

/// Owns the machine code; keep alive as long as the image runs.
class Jit {
 public:
  /// Compiles all units and fills lowered.codes; a function for each shape of lowered.steps, if there are any.
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
