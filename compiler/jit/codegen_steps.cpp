// The operations of a step as LLVM IR. compiler/lower/step_shapes.hpp defines them; compiler/emit_cpp/emit_steps.cpp
// generates the same as C++.
//
// Units are generated again in this module, so that they can be inlined. The length of the enabled set is a local
// variable, which LLVM's passes move to a register.
#include "compiler/jit/codegen_steps.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "compiler/jit/codegen.hpp"
#include "compiler/jit/debug_info.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::jit {
namespace {

using llvm::Value;
using lower::StepOp;
using lower::StepOpKind;

class StepBuilder {
 public:
  StepBuilder(llvm::IRBuilder<>& b, const lower::LoweredSystem& lowered, const lower::StepShape& shape,
              const StepFrame& frame, const std::vector<StepOperandValue>& operands, DebugInfo* debug)
      : builder_(b),
        function_(b.GetInsertBlock()->getParent()),
        module_(*function_->getParent()),
        lowered_(lowered),
        shape_(shape),
        i32_(b.getInt32Ty()),
        i64_(b.getInt64Ty()),
        on_cells_(frame.on_cells),
        cell_type_(on_cells_ ? i32_ : i64_),
        cell_align_(on_cells_ ? 4 : 8),
        debug_(debug),
        all_(frame.all),
        places_(frame.places),
        values_(frame.values),
        members_(frame.members),
        position_(frame.position),
        scratch_(frame.scratch),
        count_(frame.count),
        operands_(operands) {}

  void build() {
    for (const StepOp& op : shape_.ops) {
      if (op.guarded) open_guarded();
      else close_guarded();
      if (op.kind == StepOpKind::At || op.kind == StepOpKind::Away) test(op);
      if (op.kind == StepOpKind::Reduce) reduce(op);
      if (op.kind == StepOpKind::Copy) copy(op);
      if (op.kind == StepOpKind::Code) loop(op, [&](Value* t) { code(op, t); });
      if (op.kind == StepOpKind::Place)
        loop(op, [&](Value* t) { builder_.CreateStore(number(op, 1, t), cell(places_, op, 0, t)); });
      if (op.kind == StepOpKind::Ready) ready(op);
      if ((op.kind == StepOpKind::Interaction || op.kind == StepOpKind::Count) && op.delta != 0)
        loop(op, [&](Value* t) { grow(op, 0, t); });
    }
    close_guarded();
    for (const StepOp& op : shape_.ops) {
      if (op.kind == StepOpKind::Interaction) loop(op, [&](Value* t) { list(op, t); });
      if (op.kind == StepOpKind::Settle) loop(op, [&](Value* t) { settle(number(op, 0, t)); });
      if (op.kind == StepOpKind::SettleInOrder) settle_in_order(op);
    }
  }

 private:
  llvm::BasicBlock* new_block(const char* name) {
    return llvm::BasicBlock::Create(builder_.getContext(), name, function_);
  }
  Value* constant(std::uint32_t value) { return builder_.getInt32(value); }

  // ---- operands: ref k of an operation, which in a loop moves with t (64 bits; null outside of loops)
  static std::uint32_t operand(const StepOp& op, std::uint32_t k) { return op.first_ref + (op.repeats ? 1 : 0) + k; }
  static std::uint32_t refs(const StepOp& op) { return op.refs - (op.repeats ? 1 : 0); }
  [[nodiscard]] std::int32_t stride(const StepOp& op, std::uint32_t k) const { return shape_.strides[operand(op, k)]; }
  Value* number(const StepOp& op, std::uint32_t k, Value* t) {
    Value* base = operands_[operand(op, k)].number;
    BIP_ASSERT(operand(op, k) < operands_.size(), "operand {} of {}", operand(op, k), operands_.size());
    if (stride(op, k) == 0 || t == nullptr) return base;
    return builder_.CreateAdd(
        base, builder_.CreateMul(builder_.CreateTrunc(t, i32_), constant(static_cast<std::uint32_t>(stride(op, k)))));
  }
  Value* index(const StepOp& op, std::uint32_t k, Value* t) {
    Value* base = operands_[operand(op, k)].index;
    if (stride(op, k) == 0 || t == nullptr) return base;
    return builder_.CreateAdd(base, builder_.CreateMul(t, llvm::ConstantInt::getSigned(i64_, stride(op, k))));
  }
  Value* cell(Value* array, const StepOp& op, std::uint32_t k, Value* t) {
    return builder_.CreateInBoundsGEP(i32_, array, index(op, k, t));
  }
  Value* cell(Value* array, Value* row) {
    return builder_.CreateInBoundsGEP(i32_, array, builder_.CreateZExt(row, i64_));
  }
  Value* data(const StepOp& op, std::uint32_t k, Value* t) {
    return builder_.CreateInBoundsGEP(cell_type_, all_, index(op, k, t));
  }

  // Vectors of rows that are no neighbours would be gathered and scattered, which costs more than it saves.
  [[nodiscard]] bool has_neighbours(const StepOp& op) const {
    for (std::uint32_t k = 0; k < refs(op); ++k) {
      if (stride(op, k) != 0 && stride(op, k) != 1) return false;
    }
    return true;
  }
  void keep_scalar(llvm::Instruction* branch) {
    llvm::LLVMContext& context = builder_.getContext();
    llvm::Metadata* off[] = {llvm::MDString::get(context, "llvm.loop.vectorize.enable"),
                             llvm::ConstantAsMetadata::get(builder_.getFalse())};
    llvm::MDNode* loop = llvm::MDNode::getDistinct(context, {nullptr, llvm::MDNode::get(context, off)});
    loop->replaceOperandWith(0, loop);
    branch->setMetadata(llvm::LLVMContext::MD_loop, loop);
  }
  llvm::Instruction* count_up(Value* count, const std::function<void(Value*)>& body) {
    llvm::BasicBlock* before = builder_.GetInsertBlock();
    llvm::BasicBlock* inside = new_block("loop");
    llvm::BasicBlock* after = new_block("after");
    builder_.CreateCondBr(builder_.CreateICmpNE(count, llvm::ConstantInt::get(i64_, 0)), inside, after);
    builder_.SetInsertPoint(inside);
    llvm::PHINode* t = builder_.CreatePHI(i64_, 2);
    t->addIncoming(llvm::ConstantInt::get(i64_, 0), before);
    body(t);
    Value* next = builder_.CreateNUWAdd(t, llvm::ConstantInt::get(i64_, 1));
    t->addIncoming(next, builder_.GetInsertBlock());
    llvm::Instruction* branch = builder_.CreateCondBr(builder_.CreateICmpULT(next, count), inside, after);
    builder_.SetInsertPoint(after);
    return branch;
  }
  void loop(const StepOp& op, const std::function<void(Value*)>& body) {
    if (!op.repeats) return body(nullptr);
    llvm::Instruction* branch = count_up(operands_[op.first_ref].index, body);
    if (!has_neighbours(op)) keep_scalar(branch);
  }

  // ---- units
  llvm::Function* unit(std::uint32_t row) {
    const std::string name = (on_cells_ ? "cells." : "inline.") + lowered_.units[row].name;
    if (llvm::Function* known = module_.getFunction(name)) return known;
    llvm::Function* function =
        build_unit(module_, lowered_, row, name, debug_, on_cells_ ? lowered_.steps.cells.self_distance[row] : 0);
    function->setLinkage(llvm::Function::InternalLinkage);
    if (!function->hasFnAttribute(llvm::Attribute::OptimizeNone)) function->addFnAttr(llvm::Attribute::AlwaysInline);
    return function;
  }
  // By its row of codes, so that the row may change between steps.
  Value* call_row(std::uint32_t row, Value* self, Value* all, Value* bind) {
    Value* code = builder_.CreateConstInBoundsGEP1_64(builder_.getInt8Ty(),
                                                      module_.getOrInsertGlobal(kCodesName, builder_.getInt8Ty()),
                                                      std::uint64_t{row} * sizeof(rt::Code));
    Value* fn = builder_.CreateLoad(builder_.getPtrTy(), code);
    Value* context = builder_.CreateLoad(
        builder_.getPtrTy(),
        builder_.CreateConstInBoundsGEP1_64(builder_.getInt8Ty(), code, offsetof(rt::Code, context)));
    auto* type = llvm::FunctionType::get(
        i32_, {builder_.getPtrTy(), builder_.getPtrTy(), builder_.getPtrTy(), builder_.getPtrTy()}, false);
    llvm::CallInst* result = builder_.CreateCall(type, fn, {context, self, all, bind});
    result->setDoesNotThrow();
    return result;
  }
  // A call with self at ref k; rows of bound variables in an array, or, if all move alike in a loop, `all` moves
  // instead.
  Value* call(const StepOp& op, std::uint32_t k, Value* t) {
    const std::vector<std::uint32_t>& binds = lowered_.steps.binds[op.unit];
    BIP_ASSERT(k + 1 + binds.size() <= refs(op), "unit {} reads {} bound variables, {} operands follow", op.unit,
               binds.size(), refs(op) - k - 1);
    Value* all = all_;
    Value* bind = llvm::ConstantPointerNull::get(builder_.getPtrTy());
    if (!binds.empty()) {
      bool together = true;
      for (std::uint32_t n = 0; n < binds.size(); ++n)
        together = together && stride(op, k + 1 + n) == stride(op, k + 1);
      llvm::IRBuilder<> start(&function_->getEntryBlock(), function_->getEntryBlock().begin());
      BIP_ASSERT(std::is_sorted(binds.begin(), binds.end()), "bound variables of unit {} are not in order", op.unit);
      bind = start.CreateAlloca(llvm::ArrayType::get(i32_, binds.back() + 1));
      for (std::uint32_t n = 0; n < binds.size(); ++n) {
        builder_.CreateStore(number(op, k + 1 + n, together ? nullptr : t),
                             builder_.CreateConstInBoundsGEP1_64(i32_, bind, binds[n]));
      }
      if (together && t != nullptr && stride(op, k + 1) != 0) {
        all = builder_.CreateInBoundsGEP(cell_type_, all_,
                                         builder_.CreateMul(t, llvm::ConstantInt::getSigned(i64_, stride(op, k + 1))));
      }
    }
    if (lowered_.calls_rows) return call_row(op.unit, data(op, k, t), all, bind);
    return builder_.CreateCall(unit(op.unit),
                               {llvm::ConstantPointerNull::get(builder_.getPtrTy()), data(op, k, t), all, bind});
  }
  void zero(const StepOp& op, std::uint32_t k, Value* t) {
    if (op.zeroed == 0) return;
    Value* self = data(op, k, t);
    for (std::uint32_t n = 0; n < op.zeroed; ++n) {
      builder_.CreateAlignedStore(llvm::ConstantInt::get(cell_type_, 0),
                                  builder_.CreateConstInBoundsGEP1_64(cell_type_, self, n), cell_align_);
    }
  }
  // ---- what is executed only if atoms are where it says
  void test(const StepOp& op) {
    if (holds_ == nullptr) {
      llvm::IRBuilder<> start(&function_->getEntryBlock(), function_->getEntryBlock().begin());
      holds_ = start.CreateAlloca(builder_.getInt1Ty());
      builder_.CreateStore(builder_.getTrue(), holds_);
    }
    const llvm::CmpInst::Predicate as_said =
        op.kind == StepOpKind::At ? llvm::CmpInst::ICMP_EQ : llvm::CmpInst::ICMP_NE;
    loop(op, [&](Value* t) {
      Value* is_so =
          builder_.CreateICmp(as_said, builder_.CreateLoad(i32_, cell(places_, op, 0, t)), constant(op.from));
      builder_.CreateStore(builder_.CreateAnd(builder_.CreateLoad(builder_.getInt1Ty(), holds_), is_so), holds_);
    });
  }
  void open_guarded() {
    if (after_guarded_ != nullptr) return;
    BIP_ASSERT(holds_ != nullptr, "guarded operations without a test");
    llvm::BasicBlock* inside = new_block("guarded");
    after_guarded_ = new_block("unguarded");
    builder_.CreateCondBr(builder_.CreateLoad(builder_.getInt1Ty(), holds_), inside, after_guarded_);
    builder_.SetInsertPoint(inside);
  }
  void close_guarded() {
    if (after_guarded_ == nullptr) return;
    builder_.CreateBr(after_guarded_);
    builder_.SetInsertPoint(after_guarded_);
    holds_ = nullptr;
    after_guarded_ = nullptr;
  }
  // As wide as cells, or cells, are; of cells the largest and the least by the low half moved up, so that the sign is
  // in its place.
  Value* to_word(const StepOp& op, Value* cell) {
    const bool compares = op.reduction == lower::ReductionOp::Min || op.reduction == lower::ReductionOp::Max;
    Value* bits = builder_.CreateAlignedLoad(cell_type_, cell, cell_align_);
    return compares && !on_cells_ ? builder_.CreateShl(bits, 32) : bits;
  }
  Value* joined(const StepOp& op, Value* a, Value* b) {
    switch (op.reduction) {
      case lower::ReductionOp::Add: return builder_.CreateAdd(a, b);
      case lower::ReductionOp::Mul: return builder_.CreateMul(a, b);
      case lower::ReductionOp::And: return builder_.CreateAnd(a, b);
      case lower::ReductionOp::Or: return builder_.CreateOr(a, b);
      case lower::ReductionOp::Xor: return builder_.CreateXor(a, b);
      case lower::ReductionOp::Min: return builder_.CreateBinaryIntrinsic(llvm::Intrinsic::smin, a, b);
      case lower::ReductionOp::Max: return builder_.CreateBinaryIntrinsic(llvm::Intrinsic::smax, a, b);
    }
    return a;
  }
  void store_word(const StepOp& op, Value* word, Value* cell) {
    if (on_cells_) return void(builder_.CreateAlignedStore(word, cell, cell_align_));
    const bool compares = op.reduction == lower::ReductionOp::Min || op.reduction == lower::ReductionOp::Max;
    Value* bits =
        compares ? builder_.CreateLShr(word, 32) : builder_.CreateAnd(word, llvm::ConstantInt::get(i64_, 0xffffffffu));
    builder_.CreateAlignedStore(bits, cell, llvm::Align(8));
  }
  void reduce(const StepOp& op) {
    if (!op.repeats || stride(op, 0) != 0) {
      loop(op, [&](Value* t) {
        Value* to = data(op, 0, t);
        store_word(op, joined(op, to_word(op, to), to_word(op, data(op, 1, t))), to);
      });
      return;
    }
    llvm::IRBuilder<> start(&function_->getEntryBlock(), function_->getEntryBlock().begin());
    Value* word = start.CreateAlloca(cell_type_);
    builder_.CreateStore(to_word(op, data(op, 0, nullptr)), word);
    count_up(operands_[op.first_ref].index, [&](Value* t) {
      builder_.CreateStore(joined(op, builder_.CreateLoad(cell_type_, word), to_word(op, data(op, 1, t))), word);
    });
    store_word(op, builder_.CreateLoad(cell_type_, word), data(op, 0, nullptr));
  }

  // What stays where it is, is read once; with a code, in its loop.
  void copy(const StepOp& op) {
    const auto read = [&](Value* t) { return builder_.CreateAlignedLoad(cell_type_, data(op, 1, t), cell_align_); };
    Value* moved = stride(op, 1) == 0 ? read(nullptr) : nullptr;
    if (op.inlined) return inlined_.push_back({op.offset, moved});
    loop(op, [&](Value* t) {
      builder_.CreateAlignedStore(moved != nullptr ? moved : read(t), data(op, 0, t), cell_align_);
    });
  }

  void code(const StepOp& op, Value* t) {
    zero(op, 0, t);
    BIP_ASSERT(inlined_.empty() || (op.repeats && op.unit != rt::kNone), "copies before code that does not repeat");
    for (const auto& [offset, value] : inlined_)
      builder_.CreateAlignedStore(value, builder_.CreateConstInBoundsGEP1_64(cell_type_, data(op, 0, t), offset),
                                  cell_align_);
    inlined_.clear();
    if (op.unit != rt::kNone) call(op, 0, t);
  }

  // ---- the list
  void grow(const StepOp& op, std::uint32_t k, Value* t) {
    Value* at = cell(values_, op, k, t);
    builder_.CreateStore(
        builder_.CreateAdd(builder_.CreateLoad(i32_, at), constant(static_cast<std::uint32_t>(op.delta))), at);
  }
  void enters(Value* interaction) {
    Value* count = builder_.CreateLoad(i32_, count_);
    builder_.CreateStore(count, cell(position_, interaction));
    builder_.CreateStore(interaction, cell(members_, count));
    builder_.CreateStore(builder_.CreateAdd(count, constant(1)), count_);
  }
  void leaves(Value* interaction) {
    Value* count = builder_.CreateSub(builder_.CreateLoad(i32_, count_), constant(1));
    builder_.CreateStore(count, count_);
    Value* at = builder_.CreateLoad(i32_, cell(position_, interaction));
    Value* last = builder_.CreateLoad(i32_, cell(members_, count));
    builder_.CreateStore(last, cell(members_, at));
    builder_.CreateStore(at, cell(position_, last));
    builder_.CreateStore(constant(rt::kAbsentInteraction), cell(position_, interaction));
  }
  void list(const StepOp& op, Value* t) {
    Value* interaction = number(op, 0, t);
    if (op.change == lower::InteractionChange::Enters) return enters(interaction);
    if (op.change == lower::InteractionChange::Leaves) return leaves(interaction);
    Value* is_on = op.is_sure ? builder_.getTrue()
                              : builder_.CreateICmpSGE(builder_.CreateLoad(i32_, cell(values_, op, 0, t)), constant(0));
    for (std::uint32_t k = refs(op) - op.hiders; k < refs(op); ++k) {
      is_on = builder_.CreateAnd(
          is_on, builder_.CreateICmpSLT(builder_.CreateLoad(i32_, cell(values_, op, k, t)), constant(0)));
    }
    if (op.unit != rt::kNone) {
      zero(op, 1, t);
      is_on = builder_.CreateAnd(is_on, builder_.CreateICmpNE(call(op, 1, t), constant(0)));
    }
    // The sign says it: one comparison of two signs is all that is left of both conditions, where a comparison with
    // kAbsentInteraction would need it in a register.
    Value* was_on = builder_.CreateICmpSGE(builder_.CreateLoad(i32_, cell(position_, interaction)), constant(0));
    llvm::BasicBlock* change = new_block("change");
    llvm::BasicBlock* enter = new_block("enter");
    llvm::BasicBlock* leave = new_block("leave");
    llvm::BasicBlock* same = new_block("same");
    builder_.CreateCondBr(builder_.CreateICmpEQ(is_on, was_on), same, change);
    builder_.SetInsertPoint(change);
    builder_.CreateCondBr(is_on, enter, leave);
    builder_.SetInsertPoint(enter);
    enters(interaction);
    builder_.CreateBr(same);
    builder_.SetInsertPoint(leave);
    leaves(interaction);
    builder_.CreateBr(same);
    builder_.SetInsertPoint(same);
  }

  // rt::settle_interaction.
  void settle(Value* interaction) {
    Value* count = builder_.CreateLoad(i32_, count_);
    Value* position = builder_.CreateLoad(i32_, cell(position_, interaction));
    Value* off = builder_.CreateAShr(builder_.CreateLoad(i32_, cell(values_, interaction)), 31);
    Value* was = builder_.CreateNot(builder_.CreateAShr(position, 31));
    Value* leaves = builder_.CreateAnd(was, off);
    builder_.CreateStore(interaction, cell(members_, count));
    Value* end = builder_.CreateAdd(count, leaves);
    Value* last = builder_.CreateLoad(i32_, cell(members_, end));
    Value* hole = builder_.CreateXor(count, builder_.CreateAnd(builder_.CreateXor(count, position), leaves));
    builder_.CreateStore(last, cell(members_, hole));
    builder_.CreateStore(hole, cell(position_, last));
    Value* there =
        builder_.CreateOr(builder_.CreateAnd(position, was), builder_.CreateAnd(count, builder_.CreateNot(was)));
    builder_.CreateStore(builder_.CreateOr(there, off), cell(position_, interaction));
    builder_.CreateStore(builder_.CreateSub(end, builder_.CreateNot(builder_.CreateOr(was, off))), count_);
  }
  void settle_in_order(const StepOp& op) {
    llvm::IRBuilder<> start(&function_->getEntryBlock(), function_->getEntryBlock().begin());
    Value* changed = start.CreateAlloca(llvm::ArrayType::get(i32_, op.refs - 1));
    Value* order = builder_.CreateLoad(i32_, cell(scratch_, op, 0, nullptr));
    for (std::uint32_t k = 1; k < op.refs; ++k)
      builder_.CreateStore(number(op, k, nullptr), builder_.CreateConstInBoundsGEP1_64(i32_, changed, k - 1));
    const auto settle_those = [&](Value* word, std::uint32_t first_bit, std::uint32_t count) {
      for (std::uint32_t k = 0; k < count; ++k) {
        Value* row = builder_.CreateAnd(builder_.CreateLShr(word, first_bit + 4 * k), constant(15));
        settle(builder_.CreateLoad(i32_, cell(changed, row)));
      }
    };
    const bool is_folded = std::any_of(shape_.ops.begin(), shape_.ops.end(), [](const StepOp& count) {
      return count.kind == StepOpKind::Count && count.repeats;
    });
    if (op.to == 0 || is_folded) return settle_those(order, 0, op.refs - 1);
    using lower::OrderParts;
    std::uint32_t sure = 0, growing = 0, shrinking = 0;
    Value* some_grow = builder_.getFalse();
    Value* some_shrink = builder_.getFalse();
    std::uint32_t next = 1;  // operand
    for (const StepOp& count : shape_.ops) {
      if (count.kind != StepOpKind::Count) continue;
      BIP_ASSERT(next < op.refs, "operand {} of {} that change in order", next, op.refs);
      Value* value = builder_.CreateLoad(i32_, cell(values_, op, next++, nullptr));
      if (count.change != lower::InteractionChange::Look) {
        ++sure;
      } else if (count.delta > 0) {
        ++growing;
        some_grow = builder_.CreateOr(some_grow, builder_.CreateICmpSGE(value, constant(0)));
      } else {
        ++shrinking;
        some_shrink = builder_.CreateOr(
            some_shrink, builder_.CreateICmpSGE(value, constant(static_cast<std::uint32_t>(count.delta))));
      }
    }
    BIP_ASSERT(next == op.refs, "{} values of {}", next, op.refs);
    Value* second =
        builder_.CreateLoad(i32_, builder_.CreateConstInBoundsGEP1_64(i32_, cell(scratch_, op, 0, nullptr), op.to));
    llvm::BasicBlock* after = new_block("settled");
    const auto either = [&](Value* condition, const std::function<void()>& then, const std::function<void()>& other) {
      llvm::BasicBlock* if_so = new_block("some");
      llvm::BasicBlock* if_not = new_block("none");
      builder_.CreateCondBr(condition, if_so, if_not);
      builder_.SetInsertPoint(if_so);
      then();
      builder_.SetInsertPoint(if_not);
      other();
    };
    const auto part = [&](Value* word, std::uint32_t first_bit, std::uint32_t count) {
      return [=, &settle_those, this] {
        settle_those(word, first_bit, count);
        builder_.CreateBr(after);
      };
    };
    either(
        some_grow, [&] { either(some_shrink, part(order, 0, op.refs - 1), part(second, 0, sure + growing)); },
        [&] {
          either(some_shrink, part(second, OrderParts::kShrinkingAt, sure + shrinking),
                 part(order, OrderParts::kSureAt, sure));
        });
    builder_.SetInsertPoint(after);
  }

  // Which are ready is noted first, without branches: a branch would not be predicted.
  void ready(const StepOp& op) {
    llvm::IRBuilder<> start(&function_->getEntryBlock(), function_->getEntryBlock().begin());
    Value* count = start.CreateAlloca(i32_);
    builder_.CreateStore(constant(0), count);
    loop(op, [&](Value* t) {
      Value* found = builder_.CreateLoad(i32_, count);
      builder_.CreateStore(builder_.CreateTrunc(t, i32_), cell(scratch_, found));
      Value* is_there = builder_.CreateICmpEQ(builder_.CreateLoad(i32_, cell(places_, op, 0, t)), constant(op.from));
      builder_.CreateStore(builder_.CreateAdd(found, builder_.CreateZExt(is_there, i32_)), count);
    });
    count_up(builder_.CreateZExt(builder_.CreateLoad(i32_, count), i64_), [&](Value* k) {
      Value* t = builder_.CreateZExt(builder_.CreateLoad(i32_, builder_.CreateInBoundsGEP(i32_, scratch_, k)), i64_);
      if (op.unit != rt::kNone) call(op, 1, t);
      if (op.from != op.to) builder_.CreateStore(constant(op.to), cell(places_, op, 0, t));
      if (op.delta == 0) return;
      grow(op, refs(op) - 1, t);
      if (op.delta > 0) enters(number(op, refs(op) - 1, t));
      else leaves(number(op, refs(op) - 1, t));
    });
  }

  llvm::IRBuilder<>& builder_;
  llvm::Function* function_;
  llvm::Module& module_;
  const lower::LoweredSystem& lowered_;
  const lower::StepShape& shape_;
  llvm::Type* i32_;
  llvm::Type* i64_;
  bool on_cells_;
  llvm::Type* cell_type_;
  llvm::Align cell_align_;
  DebugInfo* debug_;
  Value *all_, *places_, *values_, *members_, *position_, *scratch_, *count_;
  const std::vector<StepOperandValue>& operands_;
  Value* holds_ = nullptr;                                 // what the tests before said
  llvm::BasicBlock* after_guarded_ = nullptr;              // among guarded operations: where the others go on
  std::vector<std::pair<std::uint32_t, Value*>> inlined_;  // copies, for the next code: which of its cells, what
};

}  // namespace

void write_step(llvm::IRBuilder<>& b, const lower::LoweredSystem& lowered, const lower::StepShape& shape,
                const StepFrame& frame, const std::vector<StepOperandValue>& operands, DebugInfo* debug) {
  BIP_ASSERT(operands.size() == shape.strides.size(), "{} operands of a shape of {}", operands.size(),
             shape.strides.size());
  StepBuilder(b, lowered, shape, frame, operands, debug).build();
}

}  // namespace bip::jit
