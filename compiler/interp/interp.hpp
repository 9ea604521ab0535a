// The reference executor: evaluates the code IR tree by tree. Small, slow and independent of LLVM; the oracle for jit
// and emit_cpp.
#pragma once
#include <memory>

#include "compiler/lower/lower.hpp"

namespace bip::interp {

/// Contexts of the interpreted code; keep alive as long as the image runs.
class Interpreter {
 public:
  /// Fills lowered.codes.
  explicit Interpreter(lower::LoweredSystem& lowered);
  ~Interpreter();
  Interpreter(const Interpreter&) = delete;
  Interpreter& operator=(const Interpreter&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bip::interp
