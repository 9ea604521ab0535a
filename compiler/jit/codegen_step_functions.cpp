// Generates the module of compiled steps: one rt::StepFn per shape, and the loop over steps. The length of the enabled
// set lives in a register and is stored at the end.
#include <cstddef>
#include <optional>

#include "compiler/jit/codegen.hpp"
#include "compiler/jit/codegen_steps.hpp"
#include "compiler/jit/debug_info.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::jit {
namespace {

using llvm::Value;

llvm::Function* declare_step(llvm::Module& module, const std::string& name) {
  llvm::LLVMContext& context = module.getContext();
  llvm::Type* pointer = llvm::PointerType::getUnqual(context);
  auto* type = llvm::FunctionType::get(llvm::Type::getVoidTy(context),
                                       {pointer, pointer, llvm::Type::getInt32Ty(context)}, false);
  auto* function = llvm::Function::Create(type, llvm::Function::ExternalLinkage, name, module);
  function->setDoesNotThrow();
  function->addParamAttr(0, llvm::Attribute::NoAlias);
  function->addParamAttr(1, llvm::Attribute::NoAlias);
  function->addParamAttr(1, llvm::Attribute::ReadOnly);
  return function;
}

void build_shape(llvm::Module& module, const lower::LoweredSystem& lowered, const lower::StepShape& shape,
                 const std::string& name, const Place& place, DebugInfo* debug) {
  llvm::Function* function = declare_step(module, name);
  llvm::IRBuilder<> b(llvm::BasicBlock::Create(module.getContext(), "entry", function));
  if (debug != nullptr) {
    debug->enter(*function, place.name, place.loc);
    b.SetCurrentDebugLocation(debug->at(*function, place.loc));
  }
  llvm::Type* i32 = b.getInt32Ty();
  llvm::Type* i64 = b.getInt64Ty();
  const auto address = [&](std::size_t offset) {
    return b.CreateConstInBoundsGEP1_64(b.getInt8Ty(), function->getArg(0), offset);
  };
  const auto array = [&](std::size_t offset) -> Value* { return b.CreateLoad(b.getPtrTy(), address(offset)); };
  const StepFrame frame{array(offsetof(rt::StepState, all)),
                        array(offsetof(rt::StepState, places)),
                        array(offsetof(rt::StepState, values)),
                        array(offsetof(rt::StepState, members)),
                        array(offsetof(rt::StepState, position)),
                        array(offsetof(rt::StepState, scratch)),
                        b.CreateAlloca(i32)};
  b.CreateStore(b.CreateLoad(i32, address(offsetof(rt::StepState, count))), frame.count);
  std::vector<StepOperandValue> operands;
  for (std::size_t k = 0; k < shape.strides.size(); ++k) {
    Value* operand = b.CreateConstInBoundsGEP1_64(i64, function->getArg(1), k);
    Value* base = b.CreateAlignedLoad(i32, operand, llvm::Align(4));
    Value* stride = shape.run_strides.empty() ? static_cast<Value*>(b.CreateAlignedLoad(
                                                    i32, b.CreateConstInBoundsGEP1_64(i32, operand, 1), llvm::Align(4)))
                                              : b.getInt32(shape.run_strides[k]);
    Value* number = b.CreateAdd(base, b.CreateMul(stride, function->getArg(2)));
    operands.push_back({number, b.CreateZExt(number, i64)});
  }
  write_step(b, lowered, shape, frame, operands, debug);
  b.CreateStore(b.CreateLoad(i32, frame.count), address(offsetof(rt::StepState, count)));
  b.CreateRetVoid();
}

}  // namespace

std::string step_name(std::size_t shape) { return "bip_shape_" + std::to_string(shape); }

std::unique_ptr<llvm::Module> build_steps(llvm::LLVMContext& context, const lower::LoweredSystem& lowered,
                                          Lines lines) {
  auto module = std::make_unique<llvm::Module>("steps", context);
  std::optional<DebugInfo> debug;
  if (lines == Lines::Yes) debug.emplace(*module, lowered.image);
  const std::vector<Place> places = debug ? shape_places(lowered) : std::vector<Place>(lowered.steps.shapes.size());
  BIP_ASSERT(places.size() == lowered.steps.shapes.size(), "{} places of {} shapes", places.size(),
             lowered.steps.shapes.size());
  std::size_t number = 0;
  for (const lower::StepShape& shape : lowered.steps.shapes) {
    build_shape(*module, lowered, shape, step_name(number), places[number], debug ? &*debug : nullptr);
    ++number;
  }
  for (const StepLoop loop : step_loops(lowered, lines)) build_step_loop(*module, lowered, loop);
  if (debug) debug->finish();
  return module;
}

}  // namespace bip::jit
