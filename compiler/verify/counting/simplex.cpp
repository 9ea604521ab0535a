// See simplex.hpp. G. Dantzig, Linear Programming and Extensions (1963), chapter 8 (revised simplex, explicit inverse).
#include "compiler/verify/counting/simplex.hpp"

#include <algorithm>
#include <cmath>

#include "runtime/include/bip/assert.hpp"
#include "runtime/include/bip/prng.hpp"

namespace bip::verify {

namespace {

constexpr double kZero = 1e-9;         // what is smaller counts as 0
constexpr double kEnlargement = 1e-7;  // of bounds, at least; at most twice as much
constexpr int kRefinements = 2;
constexpr std::uint64_t kPivotsBetweenLooks = 16;

class Simplex {
 public:
  Simplex(const LinearProgram& program, const CancellationToken& cancellation)
      : program_(program), cancellation_(cancellation), rows_(program.bounds.size()), inverse_(rows_ * rows_, 0) {
    rt::Prng prng(1);
    constexpr std::uint64_t kSteps = 1u << 20;
    for (std::size_t row = 0; row < rows_; ++row) {
      BIP_ASSERT(program.bounds[row] >= 0, "row {} is not satisfied at 0", row);
      const double share = static_cast<double>(prng.below(kSteps)) / static_cast<double>(kSteps);
      values_.push_back(program.bounds[row] + kEnlargement * (1 + share));
      inverse_[row * rows_ + row] = 1;
      basis_.push_back(program.columns.size() + row);
    }
    is_basic_.assign(program.columns.size() + rows_, 0);
    for (const std::size_t column : basis_) is_basic_[column] = 1;
    multipliers_.assign(rows_, 0);
    direction_.assign(rows_, 0);
  }

  SimplexResult run() {
    SimplexResult result;
    for (;; ++result.pivots) {
      if (result.pivots % kPivotsBetweenLooks == 0 && cancellation_.is_over()) return result;
      const std::size_t entering = best_column();
      if (entering == kNoColumn) break;
      find_direction(entering);
      const std::size_t leaving = leaving_row();
      if (leaving == rows_) return result;
      pivot(entering, leaving);
    }
    result.end = SimplexEnd::Optimal;
    for (int k = 0; k < kRefinements; ++k) refine_multipliers();
    result.multipliers = multipliers_;
    result.slack.assign(rows_, 0);
    for (std::size_t row = 0; row < rows_; ++row) {
      if (basis_[row] >= program_.columns.size()) result.slack[basis_[row] - program_.columns.size()] = values_[row];
      else result.value += program_.columns[basis_[row]].gain * values_[row];
    }
    return result;
  }

 private:
  static constexpr std::size_t kNoColumn = ~std::size_t{0};

  // What one unit of the column adds to the sum.
  [[nodiscard]] double reduced_gain(std::size_t column) const {
    if (column >= program_.columns.size()) return -multipliers_[column - program_.columns.size()];
    double gain = program_.columns[column].gain;
    for (const auto& [row, change] : program_.columns[column].changes) gain += multipliers_[row] * change;
    return gain;
  }
  [[nodiscard]] std::size_t best_column() {
    std::size_t best = kNoColumn;
    gain_ = kZero;
    for (std::size_t column = 0; column < is_basic_.size(); ++column) {
      if (is_basic_[column] != 0) continue;
      const double gain = reduced_gain(column);
      if (gain <= gain_) continue;
      best = column;
      gain_ = gain;
    }
    return best;
  }
  // Basic columns add nothing to the sum, but for rounding (iterative refinement with the inverse at hand).
  void refine_multipliers() {
    for (std::size_t row = 0; row < rows_; ++row) direction_[row] = reduced_gain(basis_[row]);
    for (std::size_t row = 0; row < rows_; ++row) {
      if (direction_[row] == 0) continue;
      for (std::size_t k = 0; k < rows_; ++k) multipliers_[k] += direction_[row] * inverse_[row * rows_ + k];
    }
  }
  // How basic columns change with one unit of the entering one: they lose so much.
  void find_direction(std::size_t entering) {
    std::fill(direction_.begin(), direction_.end(), 0);
    const auto add = [&](std::size_t column, double factor) {
      for (std::size_t row = 0; row < rows_; ++row) direction_[row] += factor * inverse_[row * rows_ + column];
    };
    if (entering >= program_.columns.size()) {
      add(entering - program_.columns.size(), 1);
      return;
    }
    for (const auto& [row, change] : program_.columns[entering].changes) add(row, -change);
  }
  // The first that becomes 0; of several the one with the largest pivot.
  [[nodiscard]] std::size_t leaving_row() const {
    std::size_t leaving = rows_;
    double least = 0;
    for (std::size_t row = 0; row < rows_; ++row) {
      if (direction_[row] <= kZero) continue;
      const double ratio = std::max(values_[row], 0.0) / direction_[row];
      if (leaving != rows_ && (ratio > least || (ratio == least && direction_[row] <= direction_[leaving]))) continue;
      leaving = row;
      least = ratio;
    }
    return leaving;
  }
  void pivot(std::size_t entering, std::size_t leaving) {
    double* const pivot_row = inverse_.data() + leaving * rows_;
    const double pivot = direction_[leaving], step = std::max(values_[leaving], 0.0) / pivot;
    nonzero_.clear();
    for (std::size_t k = 0; k < rows_; ++k) {
      if (pivot_row[k] == 0) continue;
      pivot_row[k] /= pivot;
      // The noise of numbers that cancel out.
      if (std::abs(pivot_row[k]) < kZero * kZero) pivot_row[k] = 0;
      else nonzero_.push_back(k);
    }
    for (std::size_t row = 0; row < rows_; ++row) {
      if (row == leaving || direction_[row] == 0) continue;
      values_[row] -= step * direction_[row];
      double* const other = inverse_.data() + row * rows_;
      for (const std::size_t k : nonzero_) {
        other[k] -= direction_[row] * pivot_row[k];
        if (std::abs(other[k]) < kZero) other[k] = 0;
      }
    }
    for (const std::size_t k : nonzero_) multipliers_[k] += gain_ * pivot_row[k];
    values_[leaving] = step;
    is_basic_[basis_[leaving]] = 0;
    is_basic_[entering] = 1;
    basis_[leaving] = entering;
  }

  const LinearProgram& program_;
  const CancellationToken& cancellation_;
  std::size_t rows_;
  std::vector<double> inverse_;     // of the basis, row by row
  std::vector<double> values_;      // of the basic columns
  std::vector<std::size_t> basis_;  // by row: a column, or after these the slack of a row
  std::vector<std::uint8_t> is_basic_;
  std::vector<double> multipliers_;  // by row
  std::vector<double> direction_;
  std::vector<std::size_t> nonzero_;
  double gain_ = 0;  // of the entering column
};

}  // namespace

SimplexResult maximise(const LinearProgram& program, const CancellationToken& cancellation) {
  return Simplex(program, cancellation).run();
}

}  // namespace bip::verify
