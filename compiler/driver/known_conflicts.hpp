// What the prover knows about conflicts of a distributed run (compiler/verify/conflicts), for the runtime, as text for
// people, and in the folders of `bipc deploy`: all nodes must have the same.
#pragma once
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/verify/conflicts/next_moves.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/distributed/distribution.hpp"

namespace bip::driver {

/// Seconds of processor time that a proof about conflicts may take. What is not proved by then counts as a conflict.
inline constexpr double kSecondsOfConflicts = 2;

/// Asks the prover. Requires a System.
[[nodiscard]] verify::NextMoves prove_next_moves(const Compilation& c);

/// Returns which conflicts, of those that places tell, are none, and why, or why that is not known; empty: all are.
[[nodiscard]] std::string removed_conflicts_text(const rt::Tables& tables, const verify::NextMoves& known);

/// Rows of numbers, one line each.
[[nodiscard]] std::string print_next_moves(const std::vector<rt::NextMove>& moves);
/// Fails if a line is none, or is of another model.
[[nodiscard]] Result<std::vector<rt::NextMove>> read_next_moves(const rt::Image& image, const std::string& text);

}  // namespace bip::driver
