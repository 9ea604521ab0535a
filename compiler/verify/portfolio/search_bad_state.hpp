// Searches for a bad state with the engine's own core: first a walk towards the candidate, then every state, best
// first.
//
// A result that is Found has been replayed from the initial state. Exhausted: every reachable state was visited (the
// core defines which these are), so there is no bad one. States are stored up to a bound of memory.
#pragma once
#include <string>

#include "compiler/verify/portfolio/prove_by_invariants.hpp"
#include "runtime/core/core.hpp"

namespace bip::verify {

enum class SearchEnd : std::uint8_t { Found, Exhausted, Limit };
/// Bad states: those without enabled interaction, those that satisfy a predicate, steps that end in a run-time error.
struct SearchGoal {
  bool stuck = false, faults = false;
  std::function<bool(const rt::Core&)> state;
  std::vector<std::uint32_t> atoms = {};  // all that `state` reads; empty: not known
};
/// Is the core's state a bad one? A step that ends in an error shows when it is taken.
[[nodiscard]] bool is_goal_state(const rt::Core& core, const SearchGoal& goal);
struct SearchResult {
  SearchEnd end = SearchEnd::Limit;
  /// Found: the numbers of the candidates taken; the last one ends in the error, if that is the goal.
  std::vector<std::uint64_t> choices;
  std::uint64_t states = 0;  // different ones visited
  std::string fault;         // one line of a run-time error that was met; empty: none
  std::string limit;         // Limit: which
};

struct SearchLimits {
  CancellationToken cancellation;
  std::size_t megabytes = 2048;
  std::uint64_t states = ~std::uint64_t{0};
  bool only_walk = false;                            // end after the walk towards the candidate
  std::function<void(std::uint64_t states)> report;  // called now and then; may be empty
  std::function<void(const rt::State&)> visit = {};  // called for each different state; may be empty
  std::vector<rt::VariableId> unread_cells =
      {};  // on which nothing depends: states that differ in these alone count as one
};

/// Searches until the goal, the end or a limit. `candidate`: by atom the mode to head for; empty: none is known. The
/// image must have its code. Cost: a step of the core per successor, twice the
/// state's bytes plus 200 per state.
[[nodiscard]] SearchResult search(const Net& net, const rt::Image& image, const SearchGoal& goal,
                                  const std::vector<u32>& candidate, const SearchLimits& limits);

/// Returns a text that is equal for equal states only; of images without FFI data and time.
[[nodiscard]] std::string state_key(const rt::State& state);
/// Returns the size of that text.
[[nodiscard]] std::size_t state_key_bytes(const rt::State& state);

/// Replays the choices: do they lead from the initial state to the goal? Choices may come from anywhere, a cache file
/// included. The image must have its code.
[[nodiscard]] bool reaches(const rt::Image& image, const SearchGoal& goal, const std::vector<std::uint64_t>& choices);
/// Replays the choices: the text of the fault in which they end; empty if they end in none.
[[nodiscard]] std::string fault_of(const rt::Image& image, const std::vector<std::uint64_t>& choices);

}  // namespace bip::verify
