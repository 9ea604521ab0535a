// What a portfolio is asked: a kind of question, for a state property the property itself, and the limits of the
// answer.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include "compiler/verify/portfolio/search_bad_state.hpp"
#include "compiler/verify/property/fairness.hpp"
#include "compiler/verify/property/formula.hpp"
#include "compiler/verify/property/property.hpp"
#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

/// NoLocalDeadlock: no component waits for ever while others move. Runs, Branching: no questions of a portfolio, whose
/// engines reach bad states; compiler/verify/liveness and compiler/verify/branching decide them.
enum class QuestionKind : std::uint8_t { DeadlockFreedom, NoErrors, State, NoLocalDeadlock, Runs, Branching };
struct Question {
  QuestionKind what = QuestionKind::DeadlockFreedom;
  Property property;                                // State
  Formula formula;                                  // Runs
  BranchingFormula branching;                       // Branching
  std::optional<Fairness> fairness = std::nullopt;  // Runs, Branching: what the property itself says (`under …`)
};

enum class Outcome : std::uint8_t { Holds, Violated, Unknown };

struct PortfolioLimits {
  CancellationToken cancellation;  // ends everything: cancelled by the asker, or the time is over
  std::size_t megabytes = 2048;
  bool wants_minimal_proof = false;  // reduce a proof's invariants to those that it needs
  bool wants_certificate = false;    // follow an exhaustive search by a proof, or list the states that it reached
  std::uint32_t threads = 1;         // of the exhaustive search
  bool may_search = true;            // states may be visited; a counterexample of IC3 is replayed in any case
};

/// Reports progress to a terminal: a phase and how far it is.
using Report = std::function<void(const char* phase, std::uint64_t count, const char* unit)>;

/// Returns the bad states of a question as a search takes them; of NoLocalDeadlock, which no single state shows, none.
/// `question` must outlive the result.
[[nodiscard]] SearchGoal goal_of(const Question& question);

}  // namespace bip::verify
