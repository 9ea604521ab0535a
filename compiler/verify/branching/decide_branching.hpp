// Decides a property of branching time on the graph of all reachable states and steps.
//
// The graph grows in rounds. After each the states are labelled from both sides (label_states.hpp), so that what the
// first part of the graph decides is answered without the rest. A run that shows the answer, as far as one can, is
// taken by a core from the initial state, and the conditions are evaluated on it anew before it is reported.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/verify/liveness/liveness.hpp"

namespace bip::verify {

struct ClaimOfBranches {
  std::size_t position = 0;  // after so many steps of the run
  bool has_run = false;      // each run from there has it, else none has
  std::string of_run;        // "reaches `E`", "has `always E`"
  std::uint32_t states = 0;  // that can be reached from there
  bool is_whole = true;      // no more than these
};
struct BranchingResult {
  Outcome outcome = Outcome::Unknown;
  std::string reason;                   // Unknown
  std::uint64_t states = 0, steps = 0;  // of the graph so far
  bool is_complete = false;             // all reachable states are in the graph
  bool has_errors = false;              // a step of the graph ends in a run-time error
  std::vector<std::uint64_t> choices;   // of the run: numbers of candidates, each among those of its state
  std::size_t cycle = 0;                // the choices from here on repeat
  bool repeats = false;                 // the run goes on for ever: in the cycle, or without one in its last state
  bool only_errors_follow = false;      // each step of its last state ends in a run-time error
  std::vector<ClaimOfBranches> claims;
};

/// Decides the formula in the initial state of an image that has its code, without time, C++ and random numbers and
/// without a fault in the initialization. No fairness.
[[nodiscard]] BranchingResult decide_branching(const BranchingFormula& formula, const rt::Image& image,
                                               const LivenessOptions& options);

}  // namespace bip::verify
