// Makes the table of operand_table.hpp.
#include "compiler/steps/operand_table.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "runtime/include/bip/assert.hpp"

namespace bip::steps {

namespace {

using u32 = std::uint32_t;
using i64 = std::int64_t;
using TableOperand = lower::OperandTable::Operand;

class TableMaker {
 public:
  TableMaker(const std::vector<lower::StepShape>& shapes, const std::vector<rt::StepRun>& runs,
             const std::vector<rt::StepOperand>& operands)
      : shapes_(shapes), runs_(runs), operands_(operands), runs_of_(shapes.size()), members_of_(shapes.size(), 0) {}

  lower::OperandTable make() {
    if (!choose_kinds()) return {};
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      read(chosen_[k]);
      lower::OperandTable::Kind& kind = table_.kinds.emplace_back();
      kind.shape = shapes_[chosen_[k]];
      kind.shape.run_strides.clear();
      columns_.emplace_back();
      for (u32 operand = 0; operand < values_.size(); ++operand) kind.operands.push_back(express(operand));
      members_.push_back(std::move(rows_));
    }
    fill();
    return std::move(table_);
  }

 private:
  static constexpr u32 kFewPerRun = 4;
  static constexpr std::size_t kMostKinds = 8;
  static constexpr std::uint64_t kLeastPart = 8;  // of nine
  static constexpr i64 kMostScale = 64;

  // The shapes with the most interactions, and the range of their numbers.
  bool choose_kinds() {
    std::uint64_t all = 0, known = 0;
    for (u32 row = 0; row < runs_.size(); ++row) {
      runs_of_[runs_[row].shape].push_back(row);
      members_of_[runs_[row].shape] += runs_[row].count;
      all += runs_[row].count;
    }
    if (all == 0 || runs_.size() * std::uint64_t{kFewPerRun} < all) return false;
    chosen_.resize(shapes_.size());
    std::iota(chosen_.begin(), chosen_.end(), 0u);
    std::stable_sort(chosen_.begin(), chosen_.end(), [&](u32 a, u32 b) { return members_of_[a] > members_of_[b]; });
    std::erase_if(chosen_, [&](u32 shape) { return !shapes_[shape].is_inlined() || members_of_[shape] == 0; });
    chosen_.resize(std::min(chosen_.size(), kMostKinds));
    u32 end = 0;
    table_.first = rt::kNone;
    for (const u32 shape : chosen_) {
      known += members_of_[shape];
      for (const u32 row : runs_of_[shape]) {
        const rt::StepRun& run = runs_[row];
        table_.first = std::min(table_.first, run.first);
        end = std::max(end, run.first + (run.count - 1) * run.distance + 1);
      }
    }
    if (known * (kLeastPart + 1) < all * kLeastPart) return false;
    table_.count = end - table_.first;
    table_.has_kinds = chosen_.size() > 1 || known != table_.count;
    // Others, which cannot fire, take room as well.
    return table_.count <= 2 * known;
  }

  // rows_: the members' rows in the table; values_: by operand, in the same order.
  void read(u32 shape) {
    const std::size_t operands = shapes_[shape].strides.size();
    rows_.clear();
    values_.assign(operands, {});
    for (const u32 row : runs_of_[shape]) {
      const rt::StepRun& run = runs_[row];
      for (u32 i = 0; i < run.count; ++i) {
        rows_.push_back(run.first + i * run.distance - table_.first);
        for (std::size_t k = 0; k < operands; ++k) values_[k].push_back(operands_[run.operands + k].at(i));
      }
    }
    BIP_ASSERT(!rows_.empty() && rows_.back() < table_.count, "{} rows of a shape", rows_.size());
  }

  // By its row, by another operand, or by a column of its own.
  TableOperand express(u32 operand) {
    const std::vector<u32>& values = values_[operand];
    if (const auto found = find_line(rows_, values)) return {found->first, found->second, TableOperand{}.column, 0};
    std::vector<std::vector<u32>>& columns = columns_.back();
    for (u32 column = 0; column < columns.size(); ++column) {
      const auto found = find_line(columns[column], values);
      if (found && found->second > 0 && found->second <= kMostScale)
        return {found->first, 0, column, static_cast<u32>(found->second)};
    }
    columns.push_back(values);
    return {0, 0, static_cast<u32>(columns.size() - 1), 1};
  }

  // Base and slope, if the values are an affine function with whole numbers of those at the same place in `from`.
  static std::optional<std::pair<i64, i64>> find_line(const std::vector<u32>& from, const std::vector<u32>& values) {
    std::size_t other = 1;
    while (other < from.size() && from[other] == from[0]) ++other;
    i64 slope = 0;
    if (other < from.size()) {
      const i64 rise = i64{values[other]} - values[0], run = i64{from[other]} - from[0];
      if (rise % run != 0) return std::nullopt;
      slope = rise / run;
    }
    const i64 base = values[0] - slope * from[0];
    for (std::size_t k = 0; k < from.size(); ++k) {
      if (base + slope * from[k] != values[k]) return std::nullopt;
    }
    return std::pair{base, slope};
  }

  void fill() {
    const u32 before = table_.has_kinds ? 1 : 0;
    for (const std::vector<std::vector<u32>>& columns : columns_)
      table_.width = std::max(table_.width, before + static_cast<u32>(columns.size()));
    table_.numbers.assign(std::size_t{table_.count} * table_.width, lower::OperandTable::kNoKind);
    for (u32 kind = 0; kind < columns_.size(); ++kind) {
      for (TableOperand& operand : table_.kinds[kind].operands) {
        if (operand.column != lower::OperandTable::kNoColumn) operand.column += before;
      }
      for (std::size_t k = 0; k < members_[kind].size(); ++k) {
        u32* const row = table_.numbers.data() + std::size_t{members_[kind][k]} * table_.width;
        if (table_.has_kinds) row[0] = kind;
        for (std::size_t column = 0; column < columns_[kind].size(); ++column)
          row[before + column] = columns_[kind][column][k];
      }
    }
  }

  const std::vector<lower::StepShape>& shapes_;
  const std::vector<rt::StepRun>& runs_;
  const std::vector<rt::StepOperand>& operands_;
  std::vector<std::vector<u32>> runs_of_;  // by shape
  std::vector<u32> members_of_;            // by shape
  std::vector<u32> chosen_;                // shapes
  lower::OperandTable table_;
  std::vector<u32> rows_;
  std::vector<std::vector<u32>> values_;
  std::vector<std::vector<u32>> members_;               // by kind: their rows
  std::vector<std::vector<std::vector<u32>>> columns_;  // by kind and column: of the members
};

}  // namespace

lower::OperandTable make_operand_table(const std::vector<lower::StepShape>& shapes,
                                       const std::vector<rt::StepRun>& runs,
                                       const std::vector<rt::StepOperand>& operands) {
  return TableMaker(shapes, runs, operands).make();
}

}  // namespace bip::steps
