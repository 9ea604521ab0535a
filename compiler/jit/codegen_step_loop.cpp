// The loop over compiled steps as LLVM IR: rt::take_steps (bip/step_loop.hpp) specialised to the runs with the most
// interactions, with their operands as constants. A draw is a few instructions, no address is computed twice, and the
// only calls are to steps that contain loops.
//
// There are up to three: one that draws, the same for steps in inner order on the inner arrays, and one that chooses by
// order while the list is short. If the model has no long runs, operands may come from a table
// (compiler/steps/operand_table.hpp).
//
// The core's arrays are arguments of an inner function, which tells LLVM that they do not alias. Random numbers are
// those of bip/prng.hpp; the rare case (probability n / 2^64) in which a draw is repeated calls that header's function.
#include <llvm/IR/MDBuilder.h>

#include <algorithm>
#include <cstddef>

#include "bip/prng.hpp"
#include "compiler/jit/codegen.hpp"
#include "compiler/jit/codegen_steps.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::jit {
namespace {

using llvm::Value;

static_assert(sizeof(rt::Prng) == 4 * sizeof(std::uint64_t));
constexpr unsigned kArrays = 6;  // of rt::StepState, pointers one after the other
static_assert(offsetof(rt::StepState, count) == kArrays * sizeof(void*));

class LoopBuilder {
 public:
  LoopBuilder(llvm::Module& module, const lower::LoweredSystem& lowered, StepLoop loop)
      : module_(module),
        lowered_(lowered),
        loop_(loop),
        builder_(module.getContext()),
        i32_(builder_.getInt32Ty()),
        i64_(builder_.getInt64Ty()),
        result_(llvm::StructType::get(i64_, i32_)) {}

  void build() {
    llvm::Type* pointer = builder_.getPtrTy();
    function_ = declare(loop_name(loop_) + ".arrays", {pointer, pointer, pointer, pointer, pointer, pointer, pointer,
                                                       pointer, pointer, i64_, pointer});
    function_->setLinkage(llvm::Function::InternalLinkage);
    function_->addFnAttr(llvm::Attribute::NoInline);
    build_outer();
    enter();
    write_head();
    if (is_ordered()) write_choice();
    else write_draw();
    const lower::Steps& steps = lowered_.steps;
    for (const rt::StepRun& run : loop_ == StepLoop::Inner ? steps.inner.loop : steps.loop) write_run(run);
    if (loop_ != StepLoop::Inner && !steps.table.empty()) write_table(steps.table);
    // None of those.
    builder_.CreateStore(interaction_, unknown_);
    builder_.CreateBr(end_);
    write_taken();
    write_end();
  }

 private:
  // Arguments of the inner function after the arrays.
  enum Argument : unsigned { kState = kArrays, kPrng, kHistory, kLimit, kRecent, kOrder = kPrng };

  [[nodiscard]] bool is_ordered() const { return loop_ == StepLoop::Ordered; }

  llvm::Function* declare(const std::string& name, llvm::ArrayRef<llvm::Type*> parameters) {
    auto* function = llvm::Function::Create(llvm::FunctionType::get(result_, parameters, false),
                                            llvm::Function::ExternalLinkage, name, module_);
    function->setDoesNotThrow();
    for (unsigned k = 0; k < parameters.size(); ++k) {
      if (parameters[k]->isPointerTy()) function->addParamAttr(k, llvm::Attribute::NoAlias);
    }
    return function;
  }
  llvm::BasicBlock* new_block(const char* name) {
    return llvm::BasicBlock::Create(module_.getContext(), name, function_);
  }
  Value* at(Value* object, std::size_t offset) {
    return builder_.CreateConstInBoundsGEP1_64(builder_.getInt8Ty(), object, offset);
  }
  Value* word_at(Value* object, std::uint32_t k) { return builder_.CreateConstInBoundsGEP1_64(i64_, object, k); }
  Value* cell(Value* array, Value* row) {
    return builder_.CreateInBoundsGEP(i32_, array, builder_.CreateZExt(row, i64_));
  }
  Value* number(std::uint64_t value) { return llvm::ConstantInt::get(i64_, value); }
  /// For a branch whose condition seldom holds.
  llvm::MDNode* rarely() { return llvm::MDBuilder(module_.getContext()).createUnlikelyBranchWeights(); }

  void build_outer() {
    llvm::Type* pointer = builder_.getPtrTy();
    llvm::Function* outer = declare(loop_name(loop_), {pointer, pointer, pointer, i64_});
    builder_.SetInsertPoint(llvm::BasicBlock::Create(module_.getContext(), "entry", outer));
    std::vector<Value*> arguments;
    for (unsigned k = 0; k < kArrays; ++k)
      arguments.push_back(builder_.CreateLoad(pointer, at(outer->getArg(0), k * sizeof(void*))));
    if (!lowered_.steps.cells.empty())
      arguments[0] = builder_.CreateLoad(pointer, at(outer->getArg(0), offsetof(rt::StepState, cells)));
    for (unsigned k = 0; k < 4; ++k) arguments.push_back(outer->getArg(k));
    arguments.push_back(builder_.CreateLoad(pointer, at(outer->getArg(2), offsetof(rt::StepHistory, interactions))));
    builder_.CreateRet(builder_.CreateCall(function_, arguments));
  }

  // Variables, which passes put into registers.
  void enter() {
    builder_.SetInsertPoint(new_block("entry"));
    count_ = builder_.CreateAlloca(i32_);
    unknown_ = builder_.CreateAlloca(i32_);
    left_ = builder_.CreateAlloca(i64_);
    index_ = builder_.CreateAlloca(i64_);
    for (Value*& word : words_) word = builder_.CreateAlloca(i64_);
    state_ = builder_.CreateAlloca(llvm::ArrayType::get(builder_.getInt8Ty(), sizeof(rt::StepState)));
    llvm::cast<llvm::AllocaInst>(state_)->setAlignment(llvm::Align(alignof(rt::StepState)));
    for (unsigned k = 0; k < kArrays; ++k) builder_.CreateStore(function_->getArg(k), at(state_, k * sizeof(void*)));
    builder_.CreateStore(builder_.CreateLoad(i32_, at(function_->getArg(kState), offsetof(rt::StepState, count))),
                         count_);
    builder_.CreateStore(builder_.getInt32(rt::kAbsentInteraction), unknown_);
    builder_.CreateStore(function_->getArg(kLimit), left_);
    if (is_ordered()) load_order();
    else load_words();
    Value* first = builder_.CreateZExt(
        builder_.CreateLoad(i32_, at(function_->getArg(kHistory), offsetof(rt::StepHistory, at))), i64_);
    history_end_ = builder_.CreateAdd(first, function_->getArg(kLimit));
    head_ = new_block("head");
    taken_ = new_block("taken");
    end_ = new_block("end");
    builder_.CreateBr(head_);
  }
  void load_order() {
    Value* order = function_->getArg(kOrder);
    from_ = builder_.CreateAlloca(i32_);
    least_ = builder_.CreateAlloca(i32_);
    builder_.CreateStore(builder_.CreateLoad(i32_, at(order, offsetof(rt::StepOrder, from))), from_);
    Value* follows = builder_.CreateLoad(builder_.getInt8Ty(), at(order, offsetof(rt::StepOrder, follows)));
    follows_ = builder_.CreateICmpNE(follows, builder_.getInt8(0));
  }
  void load_words() {
    for (unsigned k = 0; k < 4; ++k)
      builder_.CreateStore(builder_.CreateLoad(i64_, word_at(function_->getArg(kPrng), k)), words_[k]);
  }
  void store_words() {
    for (unsigned k = 0; k < 4; ++k)
      builder_.CreateStore(builder_.CreateLoad(i64_, words_[k]), word_at(function_->getArg(kPrng), k));
  }
  /// Where in the ring of recent interactions the next one goes.
  Value* history_at() {
    return builder_.CreateAnd(builder_.CreateSub(history_end_, builder_.CreateLoad(i64_, left_)),
                              number(rt::StepHistory::kSize - 1));
  }

  void write_head() {
    builder_.SetInsertPoint(head_);
    llvm::BasicBlock* asks = new_block("asks");
    Value* is_over = builder_.CreateICmpEQ(builder_.CreateLoad(i64_, left_), number(0));
    builder_.CreateCondBr(is_over, end_, asks, rarely());
    builder_.SetInsertPoint(asks);
    llvm::BasicBlock* draw = new_block("draw");
    // By order: nothing is enabled, or more than is searched.
    Value* rest = builder_.CreateSub(builder_.CreateLoad(i32_, count_), builder_.getInt32(1));
    Value* is_over_here = is_ordered() ? builder_.CreateICmpUGE(rest, builder_.getInt32(rt::StepOrder::kShort))
                                       : builder_.CreateICmpEQ(rest, builder_.getInt32(rt::kAbsentInteraction));
    builder_.CreateCondBr(is_over_here, end_, draw, rarely());
    builder_.SetInsertPoint(draw);
  }

  // The one at the least distance from `from`, modulo 2^32.
  void write_choice() {
    Value* count = builder_.CreateZExt(builder_.CreateLoad(i32_, count_), i64_);
    Value* from = builder_.CreateLoad(i32_, from_);
    Value* members = function_->getArg(3);
    builder_.CreateStore(builder_.CreateSub(builder_.CreateLoad(i32_, members), from), least_);
    llvm::BasicBlock* before = builder_.GetInsertBlock();
    llvm::BasicBlock* others = new_block("others");
    llvm::BasicBlock* chosen = new_block("chosen");
    builder_.CreateCondBr(builder_.CreateICmpEQ(count, number(1)), chosen, others);
    builder_.SetInsertPoint(others);
    llvm::PHINode* k = builder_.CreatePHI(i64_, 2);
    k->addIncoming(number(1), before);
    Value* distance = builder_.CreateSub(builder_.CreateLoad(i32_, builder_.CreateInBoundsGEP(i32_, members, k)), from);
    builder_.CreateStore(
        builder_.CreateBinaryIntrinsic(llvm::Intrinsic::umin, builder_.CreateLoad(i32_, least_), distance), least_);
    Value* next = builder_.CreateNUWAdd(k, number(1));
    k->addIncoming(next, others);
    builder_.CreateCondBr(builder_.CreateICmpULT(next, count), others, chosen);
    builder_.SetInsertPoint(chosen);
    interaction_ = builder_.CreateAdd(from, builder_.CreateLoad(i32_, least_));
    interaction_index_ = builder_.CreateZExt(interaction_, i64_);
  }

  Value* rotated(Value* word, unsigned by) {
    return builder_.CreateIntrinsic(llvm::Intrinsic::fshl, {i64_}, {word, word, number(by)});
  }

  // Prng::below, but for its rejections; with one candidate nothing is drawn.
  void write_draw() {
    static_assert((rt::StepHistory::kSize & (rt::StepHistory::kSize - 1)) == 0);
    Value* count = builder_.CreateZExt(builder_.CreateLoad(i32_, count_), i64_);
    builder_.CreateStore(number(0), index_);
    llvm::BasicBlock* many = new_block("many");
    llvm::BasicBlock* rare = new_block("rare");
    llvm::BasicBlock* sure = new_block("sure");
    llvm::BasicBlock* drawn = new_block("drawn");
    builder_.CreateCondBr(builder_.CreateICmpEQ(count, number(1)), drawn, many);
    builder_.SetInsertPoint(many);
    Value* w[4];
    for (unsigned k = 0; k < 4; ++k) w[k] = builder_.CreateLoad(i64_, words_[k]);
    Value* next = builder_.CreateAdd(rotated(builder_.CreateAdd(w[0], w[3]), 23), w[0]);
    llvm::Type* wide = builder_.getInt128Ty();
    Value* product = builder_.CreateMul(builder_.CreateZExt(next, wide), builder_.CreateZExt(count, wide));
    Value* high = builder_.CreateTrunc(builder_.CreateLShr(product, 64), i64_);
    builder_.CreateCondBr(builder_.CreateICmpULT(builder_.CreateTrunc(product, i64_), count), rare, sure, rarely());

    builder_.SetInsertPoint(rare);
    store_words();
    llvm::CallInst* index = builder_.CreateCall(llvm::FunctionType::get(i64_, {builder_.getPtrTy(), i64_}, false),
                                                module_.getOrInsertGlobal(kDrawName, builder_.getInt8Ty()),
                                                {function_->getArg(kPrng), count});
    index->setDoesNotThrow();
    load_words();
    builder_.CreateStore(index, index_);
    builder_.CreateBr(drawn);

    builder_.SetInsertPoint(sure);
    Value* shifted = builder_.CreateShl(w[1], 17);
    w[2] = builder_.CreateXor(w[2], w[0]);
    w[3] = builder_.CreateXor(w[3], w[1]);
    w[1] = builder_.CreateXor(w[1], w[2]);
    w[0] = builder_.CreateXor(w[0], w[3]);
    w[2] = builder_.CreateXor(w[2], shifted);
    w[3] = rotated(w[3], 45);
    for (unsigned k = 0; k < 4; ++k) builder_.CreateStore(w[k], words_[k]);
    builder_.CreateStore(high, index_);
    builder_.CreateBr(drawn);

    builder_.SetInsertPoint(drawn);
    interaction_ = builder_.CreateLoad(
        i32_, builder_.CreateInBoundsGEP(i32_, function_->getArg(3), builder_.CreateLoad(i64_, index_)));
    interaction_index_ = builder_.CreateZExt(interaction_, i64_);
  }

  StepFrame frame() {
    return {function_->getArg(0),
            function_->getArg(1),
            function_->getArg(2),
            function_->getArg(3),
            function_->getArg(4),
            function_->getArg(5),
            count_,
            !lowered_.steps.cells.empty()};
  }
  // An operand for number i of the run. In 64 bits if it stays below 2^32: then it becomes a part of addresses.
  StepOperandValue operand(const rt::StepRun& run, const rt::StepOperand& row, Value* i) {
    BIP_ASSERT(run.count != 0, "a run of no interactions");
    const std::uint64_t last = row.base + std::uint64_t{row.stride} * (run.count - 1);
    if (last > 0xffffffffu) {
      Value* narrow =
          builder_.CreateAdd(builder_.getInt32(row.base),
                             builder_.CreateMul(builder_.getInt32(row.stride), builder_.CreateTrunc(i, i32_)));
      return {narrow, builder_.CreateZExt(narrow, i64_)};
    }
    Value* index = builder_.CreateNUWAdd(number(row.base), builder_.CreateNUWMul(number(row.stride), i));
    return {builder_.CreateTrunc(index, i32_), index};
  }

  // If the interaction is one of the run, the step; what follows is for the others.
  void write_run(const rt::StepRun& run) {
    llvm::BasicBlock* inside = new_block("run");
    llvm::BasicBlock* others = new_block("others");
    Value* offset = builder_.CreateSub(interaction_index_, number(run.first));
    Value* is_inside = builder_.CreateICmpULT(offset, number(std::uint64_t{run.count} * run.distance));
    if (run.distance != 1) {
      llvm::BasicBlock* near = new_block("near");
      builder_.CreateCondBr(is_inside, near, others);
      builder_.SetInsertPoint(near);
      is_inside = builder_.CreateICmpEQ(builder_.CreateURem(offset, number(run.distance)), number(0));
    }
    builder_.CreateCondBr(is_inside, inside, others);
    builder_.SetInsertPoint(inside);
    Value* i = run.distance == 1 ? offset : builder_.CreateExactUDiv(offset, number(run.distance));
    const lower::StepCells& cells = lowered_.steps.cells;
    const lower::StepShape& shape = cells.empty() ? lowered_.steps.shapes[run.shape] : cells.shapes[run.shape];
    BIP_ASSERT(run.operands + shape.strides.size() <= (cells.empty() ? lowered_.steps.operands : cells.operands).size(),
               "operands from row {} on", run.operands);
    const rt::StepOperand* rows = (cells.empty() ? lowered_.steps.operands : cells.operands).data() + run.operands;
    if (shape.is_inlined() && (!cells.empty() || !looks_at_many(shape, rows))) {
      std::vector<StepOperandValue> operands;
      for (std::size_t k = 0; k < shape.strides.size(); ++k) operands.push_back(operand(run, rows[k], i));
      write_step(builder_, lowered_, shape, frame(), operands, nullptr);
    } else {
      call(run, shape.strides.size(), rows, i);
    }
    builder_.CreateBr(taken_);
    builder_.SetInsertPoint(others);
  }

  // An operand of the i-th interaction of the table, whose numbers are there.
  StepOperandValue operand(const lower::OperandTable::Operand& from, Value* i, Value* row) {
    Value* index = llvm::ConstantInt::getSigned(i64_, from.base);
    if (from.stride != 0)
      index = builder_.CreateAdd(index, builder_.CreateMul(i, llvm::ConstantInt::getSigned(i64_, from.stride)));
    if (from.column != lower::OperandTable::kNoColumn) {
      Value* column = builder_.CreateZExt(number_in(row, from.column), i64_);
      index = builder_.CreateAdd(index, builder_.CreateNUWMul(column, number(from.scale)));
    }
    return {builder_.CreateTrunc(index, i32_), index};
  }
  Value* number_in(Value* row, std::uint32_t column) {
    llvm::LoadInst* load = builder_.CreateLoad(i32_, builder_.CreateConstInBoundsGEP1_64(i32_, row, column));
    load->setMetadata(llvm::LLVMContext::MD_invariant_load, llvm::MDNode::get(module_.getContext(), {}));
    return load;
  }
  // If the interaction is one of the table, the step of its kind; what follows is for the others.
  void write_table(const lower::OperandTable& table) {
    llvm::BasicBlock* inside = new_block("row");
    llvm::BasicBlock* others = new_block("others");
    Value* i = builder_.CreateSub(interaction_index_, number(table.first));
    builder_.CreateCondBr(builder_.CreateICmpULT(i, number(table.count)), inside, others);
    builder_.SetInsertPoint(inside);
    Value* row = builder_.CreateInBoundsGEP(i32_, module_.getOrInsertGlobal(kOperandTableName, builder_.getInt8Ty()),
                                            builder_.CreateNUWMul(i, number(table.width)));
    llvm::SwitchInst* choice = nullptr;
    if (table.has_kinds)
      choice = builder_.CreateSwitch(number_in(row, 0), others, static_cast<unsigned>(table.kinds.size()));
    for (std::uint32_t kind = 0; kind < table.kinds.size(); ++kind) {
      if (choice != nullptr) {
        llvm::BasicBlock* step = new_block("kind");
        choice->addCase(builder_.getInt32(kind), step);
        builder_.SetInsertPoint(step);
      }
      const lower::OperandTable::Kind& known = table.kinds[kind];
      std::vector<StepOperandValue> operands;
      for (const lower::OperandTable::Operand& table_operand : known.operands)
        operands.push_back(operand(table_operand, i, row));
      write_step(builder_, lowered_, known.shape, frame(), operands, nullptr);
      builder_.CreateBr(taken_);
    }
    builder_.SetInsertPoint(others);
  }

  // Beside a long pass over who is ready a call is cheap, and what the loop has at hand stays in registers for the
  // other steps.
  static bool looks_at_many(const lower::StepShape& shape, const rt::StepOperand* rows) {
    constexpr std::uint32_t kMany = 64;
    return std::any_of(shape.ops.begin(), shape.ops.end(), [&](const lower::StepOp& op) {
      return op.kind == lower::StepOpKind::Ready && op.repeats && rows[op.first_ref].base > kMany;
    });
  }

  // Of a step that is not inlined: the function of its shape, which finds its row in this module.
  void call(const rt::StepRun& run, std::size_t count, const rt::StepOperand* rows, Value* i) {
    std::vector<std::uint32_t> cells;
    for (std::size_t k = 0; k < count; ++k) cells.insert(cells.end(), {rows[k].base, rows[k].stride});
    llvm::Constant* row = llvm::ConstantDataArray::get(module_.getContext(), cells);
    auto* table =
        new llvm::GlobalVariable(module_, row->getType(), true, llvm::GlobalValue::PrivateLinkage, row, "row");
    table->setAlignment(llvm::Align(alignof(std::uint64_t)));
    Value* length = at(state_, offsetof(rt::StepState, count));
    builder_.CreateStore(builder_.CreateLoad(i32_, count_), length);
    BIP_ASSERT(module_.getFunction(step_name(run.shape)) != nullptr, "no function for shape {}", run.shape);
    llvm::CallInst* step =
        builder_.CreateCall(module_.getFunction(step_name(run.shape)), {state_, table, builder_.CreateTrunc(i, i32_)});
    step->setDoesNotThrow();
    step->addFnAttr(llvm::Attribute::NoInline);
    builder_.CreateStore(builder_.CreateLoad(i32_, length), count_);
  }

  void write_taken() {
    builder_.SetInsertPoint(taken_);
    builder_.CreateStore(interaction_, builder_.CreateInBoundsGEP(i32_, function_->getArg(kRecent), history_at()));
    builder_.CreateStore(builder_.CreateSub(builder_.CreateLoad(i64_, left_), number(1)), left_);
    if (is_ordered()) {
      Value* after = builder_.CreateAdd(interaction_, builder_.getInt32(1));
      builder_.CreateStore(builder_.CreateSelect(follows_, after, builder_.CreateLoad(i32_, from_)), from_);
    }
    builder_.CreateBr(head_);
  }

  void write_end() {
    builder_.SetInsertPoint(end_);
    builder_.CreateStore(builder_.CreateLoad(i32_, count_),
                         at(function_->getArg(kState), offsetof(rt::StepState, count)));
    if (is_ordered())
      builder_.CreateStore(builder_.CreateLoad(i32_, from_),
                           at(function_->getArg(kOrder), offsetof(rt::StepOrder, from)));
    else store_words();
    builder_.CreateStore(builder_.CreateTrunc(history_at(), i32_),
                         at(function_->getArg(kHistory), offsetof(rt::StepHistory, at)));
    Value* steps = builder_.CreateSub(function_->getArg(kLimit), builder_.CreateLoad(i64_, left_));
    Value* result = builder_.CreateInsertValue(llvm::PoisonValue::get(result_), steps, 0);
    builder_.CreateRet(builder_.CreateInsertValue(result, builder_.CreateLoad(i32_, unknown_), 1));
  }

  llvm::Module& module_;
  const lower::LoweredSystem& lowered_;
  StepLoop loop_;
  llvm::IRBuilder<> builder_;
  llvm::Type* i32_;
  llvm::Type* i64_;
  llvm::StructType* result_;
  llvm::Function* function_ = nullptr;
  llvm::BasicBlock *head_ = nullptr, *taken_ = nullptr, *end_ = nullptr;
  Value *count_ = nullptr, *unknown_ = nullptr, *left_ = nullptr, *index_ = nullptr, *state_ = nullptr,
        *history_end_ = nullptr;
  Value* words_[4] = {};                                           // of random numbers
  Value *from_ = nullptr, *least_ = nullptr, *follows_ = nullptr;  // by order
  Value *interaction_ = nullptr, *interaction_index_ = nullptr;
};

}  // namespace

std::string loop_name(StepLoop loop) {
  switch (loop) {
    case StepLoop::Drawn: return "bip_steps";
    case StepLoop::Inner: return "bip_inner_steps";
    case StepLoop::Ordered: return "bip_ordered_steps";
  }
  BIP_UNREACHABLE("a loop over steps");
}

// Who debugs sets breakpoints at shapes, and who profiles looks between steps: for them there is no loop.
std::vector<StepLoop> step_loops(const lower::LoweredSystem& lowered, Lines lines) {
  std::vector<StepLoop> loops;
  if (lowered.calls_rows || lines == Lines::Yes) return loops;
  const lower::Steps& steps = lowered.steps;
  if (!steps.inner.loop.empty()) loops.push_back(StepLoop::Inner);
  if (!steps.loop.empty() || !steps.table.empty()) loops.insert(loops.end(), {StepLoop::Drawn, StepLoop::Ordered});
  return loops;
}

void build_step_loop(llvm::Module& module, const lower::LoweredSystem& lowered, StepLoop loop) {
  LoopBuilder(module, lowered, loop).build();
}

}  // namespace bip::jit
