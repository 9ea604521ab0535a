// The primal simplex method, for linear programs whose rows are satisfied where all unknowns are 0.
//
//   maximise sum of gain[t] * y[t]   so that   bound[r] + sum of change[r][t] * y[t] >= 0 for each row r,   y >= 0
//
// bound >= 0. Revised, with the whole inverse of the basis, in floating point; bounds are enlarged a little and
// differently, so that degenerate steps make progress (Charnes 1952). Multipliers are only suggested: who uses them
// checks them in integers. Cost: memory of rows^2; time of a pivot at most that, mostly much less.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

struct LinearProgram {
  struct Column {
    double gain = 0;
    std::vector<std::pair<std::uint32_t, double>> changes;  // row and change
  };
  std::vector<double> bounds;  // by row
  std::vector<Column> columns;
};

enum class SimplexEnd : std::uint8_t { Optimal, Limit };
struct SimplexResult {
  SimplexEnd end = SimplexEnd::Limit;
  double value = 0;                 // of the maximum
  std::vector<double> multipliers;  // by row: of the dual program, none below 0 but for rounding
  std::vector<double> slack;        // by row: its left side
  std::uint64_t pivots = 0;
};

/// Limit: the time is over, the numbers got out of hand, or the program has no maximum.
[[nodiscard]] SimplexResult maximise(const LinearProgram& program, const CancellationToken& cancellation);

}  // namespace bip::verify
