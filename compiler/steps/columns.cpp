// Computes the columns of columns.hpp. The number of a cell is the column of its variable, then the rank of the atom
// among those of its type; connectors' own variables follow in their order. Operands are mapped one by one, which also
// shows whether they still grow by equal strides.
#include "compiler/steps/columns.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::steps {

namespace {

using lower::StepOp;
using lower::StepOpKind;
using rt::kNone;
using u32 = std::uint32_t;

bool is_narrow(const rt::Span<rt::Var>& variables) {
  return std::all_of(variables.begin(), variables.end(), [](const rt::Var& v) {
    return v.type == rt::CellType::Int || v.type == rt::CellType::Bool || v.type == rt::CellType::String;
  });
}

class Layout {
 public:
  Layout(const lower::LoweredSystem& lowered, u32 atom_cells, Columns columns, lower::Steps& steps)
      : lowered_(lowered), image_(lowered.image), atom_cells_(atom_cells), columns_(columns), steps_(steps) {}

  [[nodiscard]] bool is_possible() const {
    const bool wherever = columns_ == Columns::WherePossible;
    bool goes_over_many = wherever;
    for (const rt::StepRun& run : steps_.loop) {
      const lower::StepShape& shape = steps_.shapes[run.shape];
      if (!shape.is_inlined()) return false;
      for (const StepOp& op : shape.ops) goes_over_many = goes_over_many || (op.repeats && moves_data(op));
    }
    return goes_over_many && !steps_.loop.empty() && (wherever || steps_.loop.size() == steps_.runs.size()) &&
           std::all_of(image_.atom_types.begin(), image_.atom_types.end(),
                       [](const rt::AtomType& type) { return is_narrow(type.variables); }) &&
           std::all_of(image_.connector_types.begin(), image_.connector_types.end(),
                       [](const rt::ConnectorType& type) { return is_narrow(type.variables); });
  }

  bool make() {
    number_cells();
    BIP_ASSERT(cells_.count == image_.cell_count, "{} of {} cells have a number", cells_.count, image_.cell_count);
    if (cells_.columns.empty()) return false;
    set_distances();
    std::vector<rt::StepRun> loop;
    u32 least_work = kNone;
    for (const rt::StepRun& run : steps_.loop) {
      loop.push_back(run);
      loop.back().shape = static_cast<u32>(cells_.shapes.size());
      loop.back().operands = static_cast<u32>(cells_.operands.size());
      work_ = 1;
      if (!move(run)) return false;
      least_work = std::min(least_work, work_);
    }
    if (cells_.operands.empty()) return false;
    // Filling and emptying cost as much as a few looks at each cell.
    constexpr std::uint64_t kLooks = 4;
    const std::uint64_t steps = 1 + kLooks * cells_.count / least_work;
    cells_.pay = columns_ == Columns::WherePossible ? 1 : static_cast<u32>(std::min<std::uint64_t>(steps, kNone));
    BIP_ASSERT(loop.size() == cells_.shapes.size(), "{} runs, {} shapes on cells", loop.size(), cells_.shapes.size());
    steps_.loop = std::move(loop);
    steps_.cells = std::move(cells_);
    return true;
  }

 private:
  static bool moves_data(const StepOp& op) {
    return op.kind == StepOpKind::Reduce || op.kind == StepOpKind::Copy || op.kind == StepOpKind::Code;
  }

  void number_cells() {
    std::vector<std::vector<u32>> bases(image_.atom_types.size);
    for (const rt::Atom& atom : image_.atoms) bases[atom.type].push_back(atom.first_cell);
    cell_of_.assign(image_.cell_count, kNone);
    for (u32 type = 0; type < bases.size(); ++type) {
      std::sort(bases[type].begin(), bases[type].end());
      atoms_of_.push_back(static_cast<u32>(bases[type].size()));
      for (u32 k = 0; k < image_.atom_types[type].variables.size; ++k) {
        for (const u32 base : bases[type]) add_cell(base + k);
      }
    }
    // Their data are never seen after a step: they have cells, but no columns.
    for (u32 cell = atom_cells_; cell < image_.cell_count; ++cell) cell_of_[cell] = cells_.count++;
  }
  void add_cell(u32 cell) {
    BIP_ASSERT(cell_of_[cell] == kNone, "cell {} is in two columns", cell);
    cell_of_[cell] = cells_.count;
    std::vector<rt::StepColumn>& columns = cells_.columns;
    rt::StepColumn* last = columns.empty() ? nullptr : &columns.back();
    if (last != nullptr && last->count == 1 && cell > last->cell) last->distance = cell - last->cell;
    if (last != nullptr && cell == last->cell + last->distance * last->count) ++last->count;
    else columns.push_back({cell, 1, cells_.count, 1});
    ++cells_.count;
  }
  void set_distances() {
    for (const lower::CodeUnit& unit : lowered_.units)
      cells_.self_distance.push_back(unit.owner == lower::CodeOwner::Atom ? atoms_of_[unit.owner_row] : 1);
  }

  // Which operands of an operation are cells of data: from `first` on, so many.
  static rt::Slice data_of(const StepOp& op) {
    const u32 refs = op.refs - (op.repeats ? 1 : 0);
    switch (op.kind) {
      case StepOpKind::Reduce:
      case StepOpKind::Copy:
      case StepOpKind::Code: return {0, refs};
      case StepOpKind::Ready: return {1, op.unit != kNone ? 1u : 0u};
      case StepOpKind::Interaction: return {1, op.unit != kNone ? refs - 1 - op.hiders : 0};
      case StepOpKind::At:
      case StepOpKind::Away:
      case StepOpKind::Place:
      case StepOpKind::Count:
      case StepOpKind::Settle:
      case StepOpKind::SettleInOrder: break;
    }
    return {0, 0};
  }
  /// Its self has no variables: the code gets an address that it does not use.
  [[nodiscard]] bool has_no_self(const StepOp& op) const {
    if (op.unit == kNone || op.zeroed != 0) return false;
    const lower::CodeUnit& unit = lowered_.units[op.unit];
    return unit.owner == lower::CodeOwner::Atom ? image_.atom_types[unit.owner_row].variables.size == 0
                                                : image_.connector_types[unit.owner_row].variables.size == 0;
  }

  bool move(const rt::StepRun& run) {
    cells_.shapes.push_back(steps_.shapes[run.shape]);
    lower::StepShape& shape = cells_.shapes.back();
    std::vector<rt::StepOperand> operands(
        steps_.operands.begin() + run.operands,
        steps_.operands.begin() + run.operands + static_cast<std::ptrdiff_t>(shape.strides.size()));
    for (std::size_t row = 0; row < shape.ops.size(); ++row) {
      StepOp& op = shape.ops[row];
      if (op.unit != kNone && lowered_.units[op.unit].owner == lower::CodeOwner::Priority) return false;
      u32 repeats = 1;
      if (op.repeats) {
        if (operands[op.first_ref].stride != 0) return false;
        repeats = operands[op.first_ref].base;
      }
      if (op.kind == StepOpKind::Copy && op.inlined) op.offset *= cells_.self_distance[next_code(shape, row).unit];
      const rt::Slice data = data_of(op);
      const bool is_code = op.kind != StepOpKind::Reduce && op.kind != StepOpKind::Copy;
      if (moves_data(op)) work_ += repeats;
      for (u32 k = data.first; k < data.first + data.count; ++k) {
        const u32 at = op.first_ref + (op.repeats ? 1 : 0) + k;
        if (is_code && k == data.first && has_no_self(op)) {
          operands[at] = {0, 0};
          shape.strides[at] = 0;
        } else if (!move(operands[at], shape.strides[at], run.count, repeats)) {
          return false;
        }
      }
    }
    if (!shape.run_strides.empty()) {
      for (std::size_t k = 0; k < operands.size(); ++k) shape.run_strides[k] = operands[k].stride;
    }
    cells_.operands.insert(cells_.operands.end(), operands.begin(), operands.end());
    return true;
  }
  static const StepOp& next_code(const lower::StepShape& shape, std::size_t row) {
    while (shape.ops[row].kind != StepOpKind::Code) ++row;
    BIP_ASSERT(row < shape.ops.size(), "an inlined copy before no code");
    return shape.ops[row];
  }

  // From cells base + stride * i + distance * t to cells, for i < count, t < repeats.
  bool move(rt::StepOperand& operand, std::int32_t& distance, u32 count, u32 repeats) const {
    const auto cell = [&](u32 i, u32 t) { return cell_of_[operand.at(i) + static_cast<u32>(distance) * t]; };
    const u32 base = cell(0, 0);
    const u32 stride = count > 1 ? cell(1, 0) - base : 0, step = repeats > 1 ? cell(0, 1) - base : 0;
    for (u32 i = 0; i < count; ++i) {
      for (u32 t = 0; t < repeats; ++t) {
        if (cell(i, t) != base + stride * i + step * t) return false;
      }
    }
    operand = {base, stride};
    distance = static_cast<std::int32_t>(step);
    return true;
  }

  const lower::LoweredSystem& lowered_;
  const rt::Image& image_;
  u32 atom_cells_;
  Columns columns_;
  lower::Steps& steps_;
  lower::StepCells cells_;
  std::vector<u32> cell_of_;   // by cell
  std::vector<u32> atoms_of_;  // by atom type: how many
  u32 work_ = 0;
};

}  // namespace

void lay_out_columns(const lower::LoweredSystem& lowered, u32 atom_cells, Columns columns, lower::Steps& steps) {
  Layout layout(lowered, atom_cells, columns, steps);
  if (layout.is_possible()) (void)layout.make();
}

}  // namespace bip::steps
