// Generates LLVM IR from the code IR, one function per unit.
//
// The meaning is that of code.hpp and of the interpreter: int is i32 with wrapping arithmetic, bool is i1 in
// expressions and 0/1 in cells, float is double without any fast-math flag, string is the i32 row of its text. A store
// writes all 64 bits of the cell. Divisions branch to `ret <status>`; && and || branch. Expressions recurse (`validate`
// limits their depth); statements are followed in a loop except for nested ifs.
#include "compiler/jit/codegen.hpp"

#include <llvm/IR/IRBuilder.h>

#include <limits>
#include <optional>

#include "compiler/jit/debug_info.hpp"
#include "compiler/model/operators.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::jit {
namespace {

class UnitBuilder {
 public:
  UnitBuilder(llvm::Function* function, const lower::LoweredSystem& lowered, DebugInfo* debug, std::uint32_t distance)
      : code_(*lowered.code),
        sites_(lowered.site_of_expr),
        function_(function),
        builder_(llvm::BasicBlock::Create(function->getContext(), "entry", function)),
        i32_(builder_.getInt32Ty()),
        debug_(debug),
        on_cells_(distance != 0),
        distance_(on_cells_ ? distance : 1),
        cell_type_(on_cells_ ? i32_ : builder_.getInt64Ty()),
        cell_align_(on_cells_ ? 4 : 8) {
    self_ = function->getArg(1);
    all_ = function->getArg(2);
    bind_ = function->getArg(3);
  }

  /// What follows is from there.
  void place(Loc loc) {
    if (debug_ != nullptr && loc.line != 0) builder_.SetCurrentDebugLocation(debug_->at(*function_, loc));
  }
  void guard(ExprId id) {
    place(code_.exprs[id].loc);
    builder_.CreateRet(builder_.CreateZExt(expr(id), i32_));
    limit_passes();
  }
  void action(StmtId first) {
    body(first);
    builder_.CreateRet(builder_.getInt32(1));
    limit_passes();
  }

 private:
  // InstCombine's time over conditions that dominate one another grows faster than their square: 600 divisions in one
  // expression took 4 s, 2,000 a minute. A unit with so many stays as it is.
  static constexpr std::size_t kMaxDivisions = 64;
  void limit_passes() {
    if (divisions_ <= kMaxDivisions) return;
    function_->addFnAttr(llvm::Attribute::OptimizeNone);
    function_->addFnAttr(llvm::Attribute::NoInline);
  }

  llvm::BasicBlock* new_block(const char* name) {
    return llvm::BasicBlock::Create(builder_.getContext(), name, function_);
  }

  llvm::Value* self_variable(std::uint32_t index) {
    return builder_.CreateConstInBoundsGEP1_64(cell_type_, self_, std::uint64_t{index} * distance_);
  }
  llvm::Value* bind_cell(std::uint32_t index) {
    llvm::Value* entry = builder_.CreateConstInBoundsGEP1_64(i32_, bind_, index);
    llvm::Value* row =
        builder_.CreateZExt(builder_.CreateAlignedLoad(i32_, entry, llvm::Align(4)), builder_.getInt64Ty());
    return builder_.CreateInBoundsGEP(cell_type_, all_, row);
  }
  llvm::Value* load(Type type, llvm::Value* cell) {
    if (type == Type::Float) return builder_.CreateAlignedLoad(builder_.getDoubleTy(), cell, cell_align_);
    // The address of the object.
    if (is_ffi(type)) return builder_.CreateAlignedLoad(builder_.getInt64Ty(), cell, cell_align_);
    // All of the cell, as it is stored: loops over neighbouring cells become vectors.
    llvm::Value* low = builder_.CreateTrunc(builder_.CreateAlignedLoad(cell_type_, cell, cell_align_), i32_);
    return type == Type::Bool ? builder_.CreateICmpNE(low, builder_.getInt32(0)) : low;
  }
  void store(Type type, llvm::Value* value, llvm::Value* cell) {
    // Unused bits of a cell are zero.
    if (type != Type::Float && !is_ffi(type)) value = builder_.CreateZExt(value, cell_type_);
    builder_.CreateAlignedStore(value, cell, cell_align_);
  }

  llvm::Value* expr(ExprId id) {
    const Expr& e = code_.exprs[id];
    switch (e.op) {
      case Op::ConstInt:
      case Op::ConstString: return builder_.getInt32(static_cast<std::uint32_t>(e.int_value));
      case Op::ConstBool: return builder_.getInt1(e.int_value != 0);
      case Op::ConstFloat: return llvm::ConstantFP::get(builder_.getDoubleTy(), e.float_value);
      case Op::LoadSelf: return load(e.type, self_variable(e.index));
      case Op::LoadBind: return load(e.type, bind_cell(e.index));
      case Op::Call: return call(id, e);
      case Op::IntToFloat: return builder_.CreateSIToFP(expr(e.a), builder_.getDoubleTy());
      case Op::Neg: return e.type == Type::Float ? builder_.CreateFNeg(expr(e.a)) : builder_.CreateNeg(expr(e.a));
      case Op::Not:
      case Op::BitNot: return builder_.CreateNot(expr(e.a));
      case Op::And:
      case Op::Or:
        return short_circuit(e);
        BIP_VALUE_OPS(BIP_OP_CASE)
        BIP_COMPARISON_OPS(BIP_OP_CASE)
        break;
    }
    llvm::Value* a = expr(e.a);
    llvm::Value* b = expr(e.b);
    if (code_.exprs[e.a].type == Type::Float) return float_binary(e.op, a, b);
    if (is_division(e.op)) return divide(id, e.op, a, b);
    return int_binary(e.op, a, b);
  }

  llvm::Value* cell_of(const Expr& e) { return e.op == Op::LoadSelf ? self_variable(e.index) : bind_cell(e.index); }
  /// What the process gives: a function, or data.
  llvm::Constant* process_symbol(const std::string& name) {
    return function_->getParent()->getOrInsertGlobal(name, builder_.getInt8Ty());
  }
  // One frame for all cells and their addresses of a call, at the function's start: loops there are none.
  llvm::Value* frame(llvm::Type* type, std::size_t size) {
    llvm::IRBuilder<> start(&function_->getEntryBlock(), function_->getEntryBlock().begin());
    return start.CreateAlloca(llvm::ArrayType::get(type, size == 0 ? 1 : size));
  }

  /// The cell of the object that an FFI result is assigned to: the thread's own.
  llvm::Value* result_object(ExprId call, Type result) {
    auto* type = llvm::FunctionType::get(builder_.getPtrTy(), {builder_.getPtrTy(), i32_, i32_}, false);
    llvm::Value* row = builder_.getInt32(static_cast<std::uint32_t>(ffi_row(result)));
    llvm::CallInst* cell = builder_.CreateCall(type, process_symbol(kResultName),
                                               {process_symbol(kLoweredName), builder_.getInt32(call.value), row});
    cell->setDoesNotThrow();
    return cell;
  }

  /// As rt::FfiFunction wants it. Arguments by value get cells of their own.
  llvm::Value* call(ExprId id, const Expr& e) {
    const Function& function = code_.functions[e.index];
    const std::span<const ExprId> args = code_.args_of(e);
    BIP_ASSERT(args.size() == function.params.size(), "{} arguments for `{}`", args.size(), function.name);
    llvm::Type* i64 = builder_.getInt64Ty();
    llvm::Type* pointer = builder_.getPtrTy();
    llvm::Value* values = frame(i64, args.size() + 2);
    llvm::Value* cells = frame(pointer, args.size() + 1);
    for (std::size_t k = 0; k < args.size(); ++k) {
      const Expr& arg = code_.exprs[args[k]];
      llvm::Value* cell = nullptr;
      if (function.params[k].by_reference) {
        cell = cell_of(arg);
      } else {
        llvm::Value* value = expr(args[k]);
        cell = builder_.CreateConstInBoundsGEP1_64(i64, values, k + 1);
        store(arg.type, value, cell);
      }
      builder_.CreateStore(cell, builder_.CreateConstInBoundsGEP1_64(pointer, cells, k));
    }
    llvm::Value* site = builder_.CreateConstInBoundsGEP1_64(i64, values, args.size() + 1);
    builder_.CreateStore(builder_.getInt64(sites_[id.value]), site);
    builder_.CreateStore(site, builder_.CreateConstInBoundsGEP1_64(pointer, cells, args.size()));
    llvm::Value* result = values;
    if (function.has_result && is_ffi(function.result)) result = result_object(id, function.result);
    auto* type = llvm::FunctionType::get(i32_, {pointer, pointer, pointer}, false);
    llvm::CallInst* status = builder_.CreateCall(type, process_symbol(kFunctionName + std::to_string(e.index)),
                                                 {process_symbol(kFfiContextName), result, cells});
    status->setDoesNotThrow();
    llvm::BasicBlock* faulty = new_block("exception");
    llvm::BasicBlock* sound = new_block("called");
    builder_.CreateCondBr(builder_.CreateICmpNE(status, builder_.getInt32(0)), faulty, sound);
    builder_.SetInsertPoint(faulty);
    builder_.CreateRet(
        builder_.getInt32(static_cast<std::uint32_t>(rt::fault_status(sites_[id.value], rt::FaultKind{}))));
    builder_.SetInsertPoint(sound);
    return function.has_result ? load(function.result, result) : builder_.getInt32(0);
  }
  /// An assignment between variables of an FFI type copies the object.
  void assign(Type type, llvm::Value* value, llvm::Value* cell) {
    if (!is_ffi(type)) return store(type, value, cell);
    llvm::Type* pointer = builder_.getPtrTy();
    auto* copy = llvm::FunctionType::get(builder_.getVoidTy(), {pointer, pointer}, false);
    llvm::Value* to = builder_.CreateIntToPtr(load(type, cell), pointer);
    builder_
        .CreateCall(copy, process_symbol(kCopyName + std::to_string(ffi_row(type))),
                    {to, builder_.CreateIntToPtr(value, pointer)})
        ->setDoesNotThrow();
  }

  llvm::Value* short_circuit(const Expr& e) {
    llvm::Value* a = expr(e.a);
    llvm::BasicBlock* decided = builder_.GetInsertBlock();
    llvm::BasicBlock* rest = new_block(e.op == Op::And ? "and" : "or");
    llvm::BasicBlock* join = new_block("join");
    builder_.CreateCondBr(a, e.op == Op::And ? rest : join, e.op == Op::And ? join : rest);
    builder_.SetInsertPoint(rest);
    llvm::Value* b = expr(e.b);
    llvm::BasicBlock* rest_end = builder_.GetInsertBlock();
    builder_.CreateBr(join);
    builder_.SetInsertPoint(join);
    llvm::PHINode* phi = builder_.CreatePHI(builder_.getInt1Ty(), 2);
    phi->addIncoming(builder_.getInt1(e.op == Op::Or), decided);
    phi->addIncoming(b, rest_end);
    return phi;
  }

  llvm::Value* float_binary(Op op, llvm::Value* a, llvm::Value* b) {
    switch (op) {
      case Op::Add: return builder_.CreateFAdd(a, b);
      case Op::Sub: return builder_.CreateFSub(a, b);
      case Op::Mul: return builder_.CreateFMul(a, b);
      case Op::Div: return builder_.CreateFDiv(a, b);
      case Op::Eq: return builder_.CreateFCmpOEQ(a, b);
      case Op::Ne: return builder_.CreateFCmpUNE(a, b);
      case Op::Lt: return builder_.CreateFCmpOLT(a, b);
      case Op::Gt: return builder_.CreateFCmpOGT(a, b);
      case Op::Le: return builder_.CreateFCmpOLE(a, b);
      case Op::Ge: return builder_.CreateFCmpOGE(a, b);
      case Op::Mod:
        BIP_LEAF_OPS(BIP_OP_CASE)
        BIP_UNARY_OPS(BIP_OP_CASE)
        BIP_BITWISE_OPS(BIP_OP_CASE)
        BIP_LOGIC_OPS(BIP_OP_CASE)
        break;
    }
    BIP_UNREACHABLE("not an operator of two floats");
  }
  /// int, and what bool and string share with it: == and !=.
  llvm::Value* int_binary(Op op, llvm::Value* a, llvm::Value* b) {
    switch (op) {
      case Op::Add: return builder_.CreateAdd(a, b);
      case Op::Sub: return builder_.CreateSub(a, b);
      case Op::Mul: return builder_.CreateMul(a, b);
      case Op::BitAnd: return builder_.CreateAnd(a, b);
      case Op::BitOr: return builder_.CreateOr(a, b);
      case Op::BitXor: return builder_.CreateXor(a, b);
      case Op::Eq: return builder_.CreateICmpEQ(a, b);
      case Op::Ne: return builder_.CreateICmpNE(a, b);
      case Op::Lt: return builder_.CreateICmpSLT(a, b);
      case Op::Gt: return builder_.CreateICmpSGT(a, b);
      case Op::Le: return builder_.CreateICmpSLE(a, b);
      case Op::Ge:
        return builder_.CreateICmpSGE(a, b);
        BIP_LEAF_OPS(BIP_OP_CASE)
        BIP_UNARY_OPS(BIP_OP_CASE)
        BIP_DIVISION_OPS(BIP_OP_CASE)
        BIP_LOGIC_OPS(BIP_OP_CASE)
        break;
    }
    BIP_UNREACHABLE("not an operator of two ints");
  }

  llvm::Value* divide(ExprId id, Op op, llvm::Value* a, llvm::Value* b) {
    ++divisions_;
    const std::uint32_t site = sites_[id.value];
    BIP_ASSERT(site != rt::kNone, "a division without a site, expression {}", id);
    const auto status = [&](rt::FaultKind kind) {
      return builder_.getInt32(static_cast<std::uint32_t>(rt::fault_status(site, kind)));
    };
    llvm::Value* lowest = builder_.getInt32(static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::min()));
    llvm::Value* by_zero = builder_.CreateICmpEQ(b, builder_.getInt32(0));
    llvm::Value* overflow =
        builder_.CreateAnd(builder_.CreateICmpEQ(a, lowest), builder_.CreateICmpEQ(b, builder_.getInt32(0xffffffffu)));
    llvm::BasicBlock* faulty = new_block("fault");
    llvm::BasicBlock* sound = new_block("sound");
    builder_.CreateCondBr(builder_.CreateOr(by_zero, overflow), faulty, sound);
    builder_.SetInsertPoint(faulty);
    builder_.CreateRet(
        builder_.CreateSelect(by_zero, status(rt::FaultKind::DivisionByZero), status(rt::FaultKind::DivisionOverflow)));
    builder_.SetInsertPoint(sound);
    return op == Op::Div ? builder_.CreateSDiv(a, b) : builder_.CreateSRem(a, b);
  }

  void body(StmtId first) {
    for (StmtId id = first; id.is_valid(); id = code_.stmts[id].next) {
      const Stmt& s = code_.stmts[id];
      place(s.loc);
      llvm::Value* value = expr(s.value);
      switch (s.op) {
        case StmtOp::StoreSelf: assign(s.type, value, self_variable(s.index)); break;
        case StmtOp::StoreBind: assign(s.type, value, bind_cell(s.index)); break;
        case StmtOp::If: branch(s, value); break;
        case StmtOp::Call: break;
      }
    }
  }
  void branch(const Stmt& s, llvm::Value* condition) {
    llvm::BasicBlock* then_block = new_block("then");
    llvm::BasicBlock* else_block = new_block("else");
    llvm::BasicBlock* join = new_block("fi");
    builder_.CreateCondBr(condition, then_block, else_block);
    builder_.SetInsertPoint(then_block);
    body(s.then_body);
    builder_.CreateBr(join);
    builder_.SetInsertPoint(else_block);
    body(s.else_body);
    builder_.CreateBr(join);
    builder_.SetInsertPoint(join);
  }

  const CodeTable& code_;
  const std::vector<std::uint32_t>& sites_;
  llvm::Function* function_;
  llvm::IRBuilder<> builder_;
  llvm::Type* i32_;
  DebugInfo* debug_;
  bool on_cells_;
  std::uint64_t distance_;
  llvm::Type* cell_type_;
  llvm::Align cell_align_;
  llvm::Value* self_ = nullptr;
  llvm::Value* all_ = nullptr;
  llvm::Value* bind_ = nullptr;
  std::size_t divisions_ = 0;
};

/// int32 (ptr context, ptr self, ptr all, ptr bind). self points into all, so neither is `noalias`; bind is a constant
/// table of its own.
llvm::Function* declare(llvm::Module& module, const std::string& name) {
  llvm::LLVMContext& context = module.getContext();
  llvm::Type* pointer = llvm::PointerType::getUnqual(context);
  auto* type = llvm::FunctionType::get(llvm::Type::getInt32Ty(context), {pointer, pointer, pointer, pointer}, false);
  auto* function = llvm::Function::Create(type, llvm::Function::ExternalLinkage, name, module);
  function->setDoesNotThrow();
  static constexpr const char* kArgs[] = {"context", "self", "all", "bind"};
  for (unsigned k = 0; k < 4; ++k) function->getArg(k)->setName(kArgs[k]);
  function->addParamAttr(3, llvm::Attribute::NoAlias);
  function->addParamAttr(3, llvm::Attribute::ReadOnly);
  return function;
}

}  // namespace

llvm::Function* build_unit(llvm::Module& module, const lower::LoweredSystem& lowered, std::size_t row,
                           const std::string& name, DebugInfo* debug, std::uint32_t distance) {
  const lower::CodeUnit& unit = lowered.units[row];
  BIP_ASSERT(row < lowered.units.size(), "unit {} of {}", row, lowered.units.size());
  BIP_ASSERT(module.getFunction(name) == nullptr, "two functions `{}`", name);
  llvm::Function* function = declare(module, name);
  if (debug != nullptr) debug->enter(*function, lowered.units[row].name, lowered.units[row].loc);
  UnitBuilder builder(function, lowered, debug, distance);
  builder.place(lowered.units[row].loc);
  if (unit.kind == lower::CodeKind::Guard) builder.guard(unit.expr);
  else builder.action(unit.body);
  return function;
}

std::unique_ptr<llvm::Module> build_module(llvm::LLVMContext& context, const lower::LoweredSystem& lowered,
                                           std::size_t first, std::size_t count, Lines lines) {
  auto module = std::make_unique<llvm::Module>("units_" + std::to_string(first), context);
  std::optional<DebugInfo> debug;
  if (lines == Lines::Yes) debug.emplace(*module, lowered.image);
  BIP_ASSERT(first + count <= lowered.units.size(), "units {} to {} of {}", first, first + count, lowered.units.size());
  for (std::size_t k = first; k < first + count; ++k)
    (void)build_unit(*module, lowered, k, lowered.units[k].name, debug ? &*debug : nullptr);
  if (debug) debug->finish();
  return module;
}

}  // namespace bip::jit
