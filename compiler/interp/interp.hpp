// The reference executor: evaluates the code IR tree by tree. Small, slow, needs no LLVM; the oracle for jit and emit_cpp.
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

/// Evaluates an expression that reads only Self, over `self`. Returns 1 and the value in `out`, or, with `out` as it was,
/// an rt::fault_status whose site is the row of the faulting expression (there is no image yet): its place is
/// `code.exprs[ExprId((status - 2) / 2)].loc`.
/// For guards over parameters, array sizes and component arguments at instantiation.
[[nodiscard]] std::int32_t evaluate(const CodeTable& code, ExprId expr, const rt::Slot* self, rt::Slot& out);

}  // namespace bip::interp
