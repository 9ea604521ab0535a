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

/// Conflicts, of those that places tell, that are none: counted, and by component and place.
struct RemovedConflicts {
  struct At {
    std::string component, place;
    std::size_t by_places = 0, left = 0;
    bool by_invariants = false;  // else by modes
  };
  verify::ConflictQuestion question = verify::ConflictQuestion::Answered;
  std::size_t by_modes = 0, by_invariants = 0;
  std::vector<At> places;
};
[[nodiscard]] RemovedConflicts removed_conflicts(const rt::Tables& tables, const verify::NextMoves& known);

/// Returns which conflicts are none, and why, or why that is not known; empty: all are.
[[nodiscard]] std::string removed_conflicts_text(const RemovedConflicts& removed);

/// Rows of numbers, one line each.
[[nodiscard]] std::string print_next_moves(const std::vector<rt::NextMove>& moves);
/// Fails if a line is none, or is of another model.
[[nodiscard]] Result<std::vector<rt::NextMove>> read_next_moves(const rt::Image& image, const std::string& text);

}  // namespace bip::driver
