// Derives shapes and runs, see derive_steps.hpp. Two interactions have the same shape if their folded operations are
// equal except for the operands. If there are few shapes, those whose runs have different strides are split as well,
// which makes strides constants of the code. A run continues while interactions come at equal distances and every
// operand grows by a constant stride; the borders of a ring or a grid are runs of their own.
#include "compiler/steps/derive_steps.hpp"

#include <algorithm>
#include <cstdint>
#include <map>

#include "compiler/steps/check_steps.hpp"
#include "compiler/steps/columns.hpp"
#include "compiler/steps/deriver.hpp"
#include "compiler/steps/inner_steps.hpp"
#include "compiler/steps/operand_table.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::steps {

namespace {

constexpr std::size_t kMostShapes = 64;  // with strides in them

bool alike(const StepOp& a, const StepOp& b) {
  return a.kind == b.kind && a.change == b.change && a.unit == b.unit && a.zeroed == b.zeroed && a.delta == b.delta &&
         a.from == b.from && a.to == b.to && a.hiders == b.hiders && a.refs == b.refs && a.reduction == b.reduction &&
         a.guarded == b.guarded && a.is_sure == b.is_sure;
}

// Interactions of one shape, as they come.
class Runs {
 public:
  Runs(lower::Steps& steps, u32 shape) : steps_(&steps), shape_(shape) {}

  void add(u32 interaction, const std::vector<u32>& operands) {
    BIP_ASSERT(count_ == 0 || interaction > first_ + distance_ * (count_ - 1), "interaction {} comes after {}",
               interaction, first_ + distance_ * (count_ - 1));
    BIP_ASSERT(count_ == 0 || operands.size() == bases_.size(), "{} operands, the shape has {}", operands.size(),
               bases_.size());
    if (count_ == 1) {
      distance_ = interaction - first_;
      for (std::size_t k = 0; k < operands.size(); ++k) strides_[k] = operands[k] - bases_[k];
      count_ = 2;
      return;
    }
    if (count_ > 1 && goes_on(interaction, operands)) {
      ++count_;
      return;
    }
    close();
    first_ = interaction;
    distance_ = 1;
    count_ = 1;
    bases_ = operands;
    strides_.assign(operands.size(), 0);
  }
  void close() {
    if (count_ == 0) return;
    steps_->runs.push_back({first_, count_, distance_, shape_, static_cast<u32>(steps_->operands.size())});
    for (std::size_t k = 0; k < bases_.size(); ++k) steps_->operands.push_back({bases_[k], strides_[k]});
    count_ = 0;
  }

 private:
  [[nodiscard]] bool goes_on(u32 interaction, const std::vector<u32>& operands) const {
    if (interaction != first_ + distance_ * count_) return false;
    for (std::size_t k = 0; k < operands.size(); ++k) {
      if (operands[k] != bases_[k] + strides_[k] * count_) return false;
    }
    return true;
  }

  lower::Steps* steps_;
  u32 shape_;
  u32 first_ = 0, distance_ = 1, count_ = 0;
  std::vector<u32> bases_, strides_;
};

// Tells shapes apart by the strides of their runs.
void split_by_strides(lower::Steps& steps) {
  std::map<std::vector<u32>, u32> known;
  std::vector<u32> shape_of_run;
  std::vector<lower::StepShape> shapes;
  std::vector<u32> key;
  for (const rt::StepRun& run : steps.runs) {
    const std::size_t operands = steps.shapes[run.shape].strides.size();
    key.assign(1, run.shape);
    for (std::size_t k = 0; k < operands; ++k) key.push_back(steps.operands[run.operands + k].stride);
    const auto [at, is_new] = known.try_emplace(key, static_cast<u32>(shapes.size()));
    if (is_new) {
      if (shapes.size() == kMostShapes) return;
      shapes.push_back(steps.shapes[run.shape]);
      shapes.back().run_strides.assign(key.begin() + 1, key.end());
    }
    shape_of_run.push_back(at->second);
  }
  for (std::size_t row = 0; row < steps.runs.size(); ++row) steps.runs[row].shape = shape_of_run[row];
  BIP_ASSERT(shape_of_run.size() == steps.runs.size() && shapes.size() <= kMostShapes, "{} shapes of {} runs",
             shapes.size(), steps.runs.size());
  steps.shapes = std::move(shapes);
}

// What operations may put into the list.
void list_entries(lower::Steps& steps) {
  for (u32 shape = 0; shape < steps.shapes.size(); ++shape) {
    for (const StepOp& op : steps.shapes[shape].ops) {
      const bool is_listed = op.kind == StepOpKind::Interaction || (op.kind == StepOpKind::Ready && op.delta != 0);
      // A value that shrinks lets nothing in, unless something else is looked at as well.
      const bool may_enter =
          op.change == InteractionChange::Look &&
          (op.delta > 0 || op.hiders != 0 || (op.kind == StepOpKind::Interaction && op.unit != kNone));
      if (!is_listed || (!may_enter && op.change != InteractionChange::Enters)) continue;
      const u32 operand =
          op.kind == StepOpKind::Ready ? op.first_ref + op.refs - 1 : op.first_ref + (op.repeats ? 1 : 0);
      steps.entries.push_back({shape, operand, op.repeats ? op.first_ref : rt::StepEntry::kOnce,
                               static_cast<u32>(steps.shapes[shape].strides[operand])});
    }
  }
}

}  // namespace

std::vector<u32> shape_key(const Instance& folded, const std::vector<std::int32_t>& strides) {
  std::vector<u32> key;
  for (const StepOp& op : folded.ops) {
    key.insert(key.end(),
               {static_cast<u32>(op.kind), static_cast<u32>(op.change), op.repeats ? 1u : 0u, op.unit, op.zeroed,
                static_cast<u32>(op.delta), op.from, op.to, op.hiders, op.refs, static_cast<u32>(op.reduction),
                op.inlined ? 1u : 0u, op.offset, op.guarded ? 1u : 0u, op.is_sure ? 1u : 0u});
  }
  for (const std::int32_t stride : strides) key.push_back(static_cast<u32>(stride));
  return key;
}

std::vector<rt::StepRun> choose_loop(std::vector<rt::StepRun> runs, std::uint64_t interactions) {
  constexpr std::size_t kMostRuns = 6;
  constexpr std::uint64_t kLeastPart = 8;  // of nine
  std::stable_sort(runs.begin(), runs.end(),
                   [](const rt::StepRun& a, const rt::StepRun& b) { return a.count > b.count; });
  runs.resize(std::min(runs.size(), kMostRuns));
  std::uint64_t known = 0;
  for (const rt::StepRun& run : runs) known += run.count;
  if (known * (kLeastPart + 1) < interactions * kLeastPart) runs.clear();
  return runs;
}

void fold(const Instance& in, std::size_t least, Instance& out, std::vector<std::int32_t>& strides) {
  out.clear();
  strides.clear();
  const auto ref = [&](std::size_t op, u32 k) { return in.refs[in.ops[op].first_ref + k]; };
  for (std::size_t i = 0; i < in.ops.size();) {
    const StepOp& op = in.ops[i];
    std::size_t end = i + 1;
    const auto goes_on = [&] {
      // Their order is no regularity.
      if (op.kind == StepOpKind::Settle || end >= in.ops.size() || !alike(op, in.ops[end])) return false;
      for (u32 k = 0; k < op.refs; ++k) {
        if (ref(end, k) - ref(end - 1, k) != ref(i + 1, k) - ref(i, k)) return false;
      }
      return true;
    };
    while (goes_on()) ++end;
    // Who is ready is always asked in a loop.
    const bool repeats = end - i >= (op.kind == StepOpKind::Ready ? 1 : least);
    if (!repeats) end = i + 1;
    StepOp& made = out.add(op.kind);
    BIP_ASSERT(op.first_ref + op.refs <= in.refs.size(), "operands {} to {} of {}", op.first_ref,
               op.first_ref + op.refs, in.refs.size());
    const u32 first = made.first_ref;
    made = op;
    made.first_ref = first;
    made.repeats = repeats;
    made.refs = 0;
    if (repeats) {
      out.ref(static_cast<u32>(end - i));
      strides.push_back(0);
    }
    for (u32 k = 0; k < op.refs; ++k) {
      out.ref(ref(i, k));
      strides.push_back(repeats && end - i > 1 ? static_cast<std::int32_t>(ref(i + 1, k) - ref(i, k)) : 0);
    }
    i = end;
  }
}

void derive_steps(lower::LoweredSystem& lowered, Columns columns) {
  // Compiled steps draw uniformly.
  if (rt::is_weighted(lowered.image)) return;
  lowered.steps = {};
  lowered.image.step_runs = {};
  lowered.image.step_entries = {};
  lowered.image.step_columns = {};
  lowered.image.step_cells = 0;
  lowered.image.inner_steps = {};
  // Objects of C++ types are no data of ours.
  if (lowered.image.ffi != nullptr || lowered.system->code.has_draws()) return;
  Deriver deriver(lowered);
  // Generated code tells by the sign of a position whether an interaction is in the list.
  if (deriver.interactions() > static_cast<u32>(INT32_MAX) || !deriver.link_priorities()) return;
  lower::Steps steps;
  std::map<std::vector<u32>, u32> known;
  std::vector<Runs> runs;
  Instance instance, folded;
  std::vector<std::int32_t> strides;
  bool has_all = true;
  for (const rt::InteractionId interaction : deriver.tables().interactions.ids()) {
    Deriver::Found found = deriver.describe(interaction, instance);
    if (found == Deriver::Found::Yes) {
      fold(instance, kLeastRepeats, folded, strides);
      inline_copies(folded, strides, deriver.atom_cells());
      if (folded.ops.size() > kMostOps) found = Deriver::Found::No;
    }
    if (found == Deriver::Found::No && deriver.needs_all()) return;
    has_all = has_all && found != Deriver::Found::No;
    if (found != Deriver::Found::Yes) continue;
    const auto [at, is_new] = known.try_emplace(shape_key(folded, strides), static_cast<u32>(runs.size()));
    if (is_new) {
      steps.shapes.push_back({folded.ops, strides, {}});
      runs.emplace_back(steps, at->second);
    }
    runs[at->second].add(interaction.value, folded.refs);
  }
  for (Runs& rest : runs) rest.close();
  const std::vector<lower::StepShape> shapes = steps.shapes;
  const std::vector<rt::StepRun> runs_of_shapes = steps.runs;
  split_by_strides(steps);
  list_entries(steps);
  std::uint64_t with_steps = 0;
  for (const rt::StepRun& run : steps.runs) with_steps += run.count;
  steps.loop = choose_loop(steps.runs, with_steps);
  for (const lower::CodeFacts& facts : deriver.facts()) steps.binds.push_back(facts.binds);
  if (has_all && steps.loop.empty()) {
    const bool wherever = columns == Columns::WherePossible;
    derive_inner_steps(deriver, lowered, wherever ? InnerOrders::WherePossible : InnerOrders::WhereOfUse, steps);
  }
  if (steps.loop.empty() && steps.inner.runs.empty())
    steps.table = make_operand_table(shapes, runs_of_shapes, steps.operands);
  if (has_all || columns == Columns::WherePossible) lay_out_columns(lowered, deriver.atom_cells(), columns, steps);
  lowered.steps = std::move(steps);
  lowered.image.step_runs = {lowered.steps.runs.data(), static_cast<u32>(lowered.steps.runs.size())};
  lowered.image.step_columns = {lowered.steps.cells.columns.data(),
                                static_cast<u32>(lowered.steps.cells.columns.size())};
  lowered.image.step_cells = lowered.steps.cells.count;
  lowered.image.step_cells_pay = lowered.steps.cells.pay;
  lowered.image.step_operands = {lowered.steps.operands.data(), static_cast<u32>(lowered.steps.operands.size())};
  lowered.image.step_entries = {lowered.steps.entries.data(), static_cast<u32>(lowered.steps.entries.size())};
  const lower::InnerStepRows& inner = lowered.steps.inner;
  const auto span = [](const std::vector<u32>& rows) {
    return rt::Span<u32>{rows.data(), static_cast<u32>(rows.size())};
  };
  lowered.image.inner_steps = {span(inner.atoms),
                               span(inner.interactions),
                               span(inner.cells),
                               span(inner.run_of),
                               {inner.runs.data(), static_cast<u32>(inner.runs.size())},
                               inner.pay};
  BIP_ASSERT(check_steps(lowered, deriver.interactions()), "steps of {} interactions", deriver.interactions());
}

}  // namespace bip::steps
