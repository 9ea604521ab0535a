// Shapes of interactions, from which step functions are generated (bip/steps.hpp); compiler/steps derives them.
//
// A shape is a list of operations. Interactions of one shape differ in the operands, which are numbered through the
// operations in order: `refs` of them for each operation, after a count if the operation repeats.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "runtime/include/bip/image.hpp"

namespace bip::lower {

enum class StepOpKind : std::uint8_t {
  Reduce,  // refs to, from: from's value joins to's, by an operation on ints or bools that any order does with the same
           // bits; no `from` is a `to`
  Copy,    // refs to, from: all of the variable. If it is `inlined`, it is done in the loop of the next Code, whose
           // self's variable `offset` is `to`; `from` stays where it is, and is read before
  Code,    // runs `unit`: refs self, then its bound variables (code_facts); zeroes so many of self's variables before
  At,      // refs atom: the `guarded` operations that follow are executed only if the atom is at `from`,
  Away,    // or elsewhere; one after the other: if all of that holds
  Place,   // refs atom, place: the atom is there now
  Ready,   // refs atom, self if there is a unit, interaction if delta != 0: if the atom is at `from`, runs `unit`, puts
           // it at `to`, the interaction's value grows by delta and it enters
  Count,   // refs interaction: its value grows by delta
  Settle,  // refs interaction: it is in the list iff it is available; without branches
  SettleInOrder,  // refs the fired interaction, then up to eight others, which it settles: in the order that four bits
                  // for each of them in the fired one's row of scratch say; `to`: see OrderParts
  Interaction  // refs interaction, then, if there is a guard `unit`, self and bound variables, then interactions that
               // hide it: its value grows by delta, and it is in the list iff it is available, the guard holds and none
               // of those is available
};
enum class ReductionOp : std::uint8_t { Add, Mul, And, Or, Xor, Min, Max };
enum class InteractionChange : std::uint8_t { Look, Enters, Leaves };  // what is certain

struct StepOp {
  StepOpKind kind = StepOpKind::Code;
  InteractionChange change = InteractionChange::Look;
  ReductionOp reduction = ReductionOp::Add;
  bool inlined = false;      // Copy
  bool guarded = false;      // Reduce, Copy, Code: by At and Away
  bool is_sure = false;      // Interaction: it is available in every state
  std::uint32_t offset = 0;  // Copy that is inlined
  bool repeats = false;      // a first operand says how often; strides say how far the others move each time
  std::uint32_t unit = rt::kNone;
  std::uint32_t zeroed = 0;
  std::int32_t delta = 0;
  std::uint32_t from = 0, to = 0;
  std::uint32_t hiders = 0;  // Interaction: the last so many refs
  std::uint32_t first_ref = 0, refs = 0;
};
/// SettleInOrder with `to` rows of scratch to a second number: the Counts before it are those of its interactions, one
/// by one unless they are folded, and say which are sure to change. The others change only if a value that has grown is
/// now available, or if one that has shrunk was. The orders without those that do not change are in the fired one's
/// numbers: of the sure ones alone in the first, behind the order of all; in the second of the sure ones with those
/// that grow, and with those that shrink. Four bits each.
struct OrderParts {
  static constexpr std::uint32_t kMost = 6, kMostSure = 2, kMostWith = 4;  // so that two numbers hold the orders
  static constexpr std::uint32_t kSureAt = 24, kShrinkingAt = 16;          // the first bit; else 0
};
struct StepShape {
  std::vector<StepOp> ops;            // Ats, Aways, Reduces, Copies and Codes, then Places, Readys, Counts, Settles and
                                      // Interactions; of the last first all values, then the list, in order
  std::vector<std::int32_t> strides;  // by operand; 0 unless its operation repeats
  std::vector<std::uint32_t>
      run_strides;  // by operand: what StepOperand::stride is in all runs of the shape; empty: it varies

  [[nodiscard]] bool has_loops() const {
    return std::any_of(ops.begin(), ops.end(), [](const StepOp& op) { return op.repeats; });
  }
  /// Into a loop over steps; else called by it, so that what the loop has at hand stays in registers.
  [[nodiscard]] bool is_inlined() const {
    constexpr std::size_t kMostOps = 24;
    return ops.size() <= kMostOps;
  }
};
/// Data while a loop over steps runs, if all of them have 32 bits: a column for each variable of each type of atoms, so
/// that interactions of many go over neighbours. What the loop knows works on these, then.
struct StepCells {
  std::uint32_t count = 0;  // 0: it works on cells of 8 bytes
  std::uint32_t pay = 0;    // steps after which filling the columns has paid
  std::vector<rt::StepColumn> columns;
  std::vector<StepShape> shapes;
  std::vector<rt::StepOperand> operands;
  std::vector<std::uint32_t> self_distance;  // by unit: from one variable of self to the next

  [[nodiscard]] bool empty() const { return count == 0; }
};
/// Operands of interactions that no affine function gives, for the loop over steps: a row of `width` numbers for each
/// of `count` interactions from `first` on. If `has_kinds`, the first number of a row is its kind, or kNoKind; else all
/// are of the only kind.
struct OperandTable {
  static constexpr std::uint32_t kNoKind = 0xffffffffu, kNoColumn = 0xffffffffu;
  struct Operand {  // base + stride * i + scale * the number in the column, of the i-th interaction
    std::int64_t base = 0, stride = 0;
    std::uint32_t column = kNoColumn, scale = 0;
  };
  struct Kind {
    StepShape shape;
    std::vector<Operand> operands;
  };
  std::uint32_t first = 0, count = 0, width = 0;
  bool has_kinds = false;
  std::vector<Kind> kinds;
  std::vector<std::uint32_t> numbers;

  [[nodiscard]] bool empty() const { return kinds.empty(); }
};
/// What rt::InnerSteps points to.
struct InnerStepRows {
  std::vector<std::uint32_t> atoms, interactions, cells, run_of;
  std::vector<rt::StepRun> runs;
  std::vector<rt::StepRun> loop;  // those that a loop over steps on the inner arrays knows; empty: no loop
  std::uint32_t pay = 0;
};
struct Steps {
  std::vector<StepShape> shapes;
  std::vector<rt::StepRun> runs;
  std::vector<rt::StepRun>
      loop;         // those that a loop over steps (rt::StepsFn) knows, in the order in which it asks; empty: no loop
  StepCells cells;  // if not empty, shapes and operands of the rows of `loop` are those there
  OperandTable table;  // what the loop knows if `loop` and `inner` are empty
  std::vector<rt::StepOperand> operands;
  std::vector<rt::StepEntry> entries;             // by shape
  InnerStepRows inner;                            // its shapes and operands are among those above
  std::vector<std::vector<std::uint32_t>> binds;  // by unit: its bound variables, as CodeFacts has them
};

}  // namespace bip::lower
