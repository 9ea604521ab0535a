// The operations of a step as LLVM IR, appended at a builder's position: in a function of one shape, or in a loop over
// steps. Internal to jit/.
#pragma once
#include <llvm/IR/IRBuilder.h>

#include <vector>

#include "compiler/jit/codegen.hpp"
#include "compiler/lower/lower.hpp"

namespace bip::jit {

class DebugInfo;

/// What a step works on: rt::StepState's arrays; `count` is the address of a variable. `all` may be its cells.
struct StepFrame {
  llvm::Value *all, *places, *values, *members, *position, *scratch, *count;
  bool on_cells = false;
};
/// An operand with 32 bits, and with 64 (zero above).
struct StepOperandValue {
  llvm::Value *number, *index;
};

void write_step(llvm::IRBuilder<>& b, const lower::LoweredSystem& lowered, const lower::StepShape& shape,
                const StepFrame& frame, const std::vector<StepOperandValue>& operands, DebugInfo* debug);

/// Adds the loop, called loop_name(loop). It knows the rows of lowered.steps.loop and the table, or those of
/// inner.loop, and draws as rt::take_steps does; the functions of shapes are in the module. A draw that rt::Prng might
/// reject it leaves to kDrawName.
void build_step_loop(llvm::Module& module, const lower::LoweredSystem& lowered, StepLoop loop);

}  // namespace bip::jit
