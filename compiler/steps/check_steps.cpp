// See check_steps.hpp.
#include "compiler/steps/check_steps.hpp"

#include <initializer_list>
#include <vector>

#include "runtime/include/bip/assert.hpp"

namespace bip::steps {

namespace {

using lower::StepOp;
using lower::StepOpKind;
using u32 = std::uint32_t;

// Each operand belongs to one operation, in their order; only what repeats moves within a step.
void check_shape(const lower::LoweredSystem& lowered, const lower::StepShape& shape, [[maybe_unused]] std::size_t row) {
  u32 next = 0;
  for (const StepOp& op : shape.ops) {
    BIP_ASSERT(op.first_ref == next && op.refs >= (op.repeats ? 2u : 1u), "shape {} has an operation of {} operands",
               row, op.refs);
    BIP_ASSERT(op.unit == rt::kNone || op.unit < lowered.units.size(), "shape {} runs unit {} of {}", row, op.unit,
               lowered.units.size());
    BIP_ASSERT(op.hiders == 0 || (op.kind == StepOpKind::Interaction && op.hiders < op.refs),
               "shape {} has {} interactions that hide another", row, op.hiders);
    BIP_ASSERT(
        !op.guarded || op.kind == StepOpKind::Reduce || op.kind == StepOpKind::Copy || op.kind == StepOpKind::Code,
        "shape {} guards what is no transfer", row);
    BIP_ASSERT(!op.inlined || op.kind == StepOpKind::Copy, "shape {} inlines what is no copy", row);
    next += op.refs;
    for (u32 k = op.first_ref; k < next && !op.repeats; ++k)
      BIP_ASSERT(k < shape.strides.size() && shape.strides[k] == 0, "operand {} of shape {} moves", k, row);
  }
  BIP_ASSERT(shape.strides.size() == next, "shape {} has {} strides of {} operands", row, shape.strides.size(), next);
  BIP_ASSERT(shape.run_strides.empty() || shape.run_strides.size() == next, "shape {} has {} strides of its runs", row,
             shape.run_strides.size());
}

// What is at the borders of a run is inside the core's arrays: operands are affine.
void check_operands(const lower::LoweredSystem& lowered, const rt::StepRun& run, const lower::StepShape& shape,
                    std::initializer_list<u32> members, [[maybe_unused]] u32 interactions) {
  const rt::StepOperand* const operands = lowered.steps.operands.data() + run.operands;
  for (const StepOp& op : shape.ops) {
    const u32 first = op.first_ref + (op.repeats ? 1 : 0);
    for (const u32 i : members) {
      [[maybe_unused]] const u32 at = operands[first].at(i);
      switch (op.kind) {
        case StepOpKind::Reduce:
        case StepOpKind::Copy:
          BIP_ASSERT(at < lowered.image.cell_count, "cell {} of {}", at, lowered.image.cell_count);
          break;
        case StepOpKind::Code:
          BIP_ASSERT(at <= lowered.image.cell_count, "self at cell {} of {}", at, lowered.image.cell_count);
          break;
        case StepOpKind::At:
        case StepOpKind::Away:
        case StepOpKind::Place:
        case StepOpKind::Ready:
          BIP_ASSERT(at < lowered.image.atoms.size, "atom {} of {}", at, lowered.image.atoms.size);
          break;
        case StepOpKind::Count:
        case StepOpKind::Settle:
        case StepOpKind::SettleInOrder:
        case StepOpKind::Interaction: BIP_ASSERT(at < interactions, "interaction {} of {}", at, interactions); break;
      }
    }
  }
}

}  // namespace

bool check_steps(const lower::LoweredSystem& lowered, u32 interactions) {
  const lower::Steps& steps = lowered.steps;
  for (std::size_t row = 0; row < steps.shapes.size(); ++row) check_shape(lowered, steps.shapes[row], row);
  std::vector<bool> has_run(interactions, false);
  for (const rt::StepRun& run : steps.runs) {
    BIP_ASSERT(run.shape < steps.shapes.size() && run.count != 0 && run.distance != 0, "a run of shape {} of {}",
               run.shape, steps.shapes.size());
    BIP_ASSERT(run.operands + steps.shapes[run.shape].strides.size() <= steps.operands.size(),
               "a run has its operands from row {} on, of {}", run.operands, steps.operands.size());
    for (u32 k = 0; k < run.count; ++k) {
      const u32 interaction = run.first + k * run.distance;
      BIP_ASSERT(interaction < interactions && !has_run[interaction], "interaction {} is in two runs", interaction);
      has_run[interaction] = true;
    }
    check_operands(lowered, run, steps.shapes[run.shape], {0u, run.count - 1}, interactions);
  }
  const lower::InnerStepRows& inner = steps.inner;
  for (u32 k = 0; k < inner.interactions.size(); ++k) {
    if (inner.run_of[k] == rt::kNone) continue;
    const rt::StepRun& run = inner.runs[inner.run_of[k]];
    BIP_ASSERT(run.shape < steps.shapes.size() && run.first <= k && k < run.first + run.count,
               "inner interaction {} is in a run of {} from {} on", k, run.count, run.first);
    check_operands(lowered, run, steps.shapes[run.shape], {k - run.first}, interactions);
  }
  for (const rt::StepRun& run : inner.loop)
    check_operands(lowered, run, steps.shapes[run.shape], {0u, run.count - 1}, interactions);
  const lower::OperandTable& table = steps.table;
  BIP_ASSERT(table.numbers.size() == std::size_t{table.count} * table.width &&
                 table.first + std::uint64_t{table.count} <= interactions,
             "a table of {} numbers", table.numbers.size());
  for (const lower::OperandTable::Kind& kind : table.kinds) {
    check_shape(lowered, kind.shape, 0);
    for ([[maybe_unused]] const lower::OperandTable::Operand& operand : kind.operands)
      BIP_ASSERT(operand.column == lower::OperandTable::kNoColumn || operand.column < table.width, "column {} of {}",
                 operand.column, table.width);
  }
  const lower::StepCells& cells = steps.cells;
  BIP_ASSERT(cells.empty() || cells.self_distance.size() == lowered.units.size(), "distances of {} of {} units",
             cells.self_distance.size(), lowered.units.size());
  u32 next = 0;
  for (const rt::StepColumn& column : cells.columns) {
    BIP_ASSERT(column.column_cell == next && column.count != 0, "a column at {}, not {}", column.column_cell, next);
    BIP_ASSERT(column.cell + std::uint64_t{column.count - 1} * column.distance < lowered.image.cell_count,
               "a column of {} cells from {} on", column.count, column.cell);
    next += column.count;
  }
  BIP_ASSERT(next <= cells.count || cells.empty(), "{} cells in columns, of {}", next, cells.count);
  for ([[maybe_unused]] const rt::StepRun& run : steps.loop) {
    BIP_ASSERT(run.shape < (cells.empty() ? steps.shapes : cells.shapes).size(), "the loop takes steps of shape {}",
               run.shape);
  }
  return true;
}

}  // namespace bip::steps
