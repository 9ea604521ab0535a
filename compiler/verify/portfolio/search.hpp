// Looks for a bad state with the engine's own core: first a walk towards the candidate, then every state, best first.
//
// What is found has been replayed from the initial state. Exhausted means that every reachable state was
// visited (the core decides what that is), so that there is no such state. States are kept in memory up to a bound.
#pragma once
#include <string>

#include "compiler/verify/portfolio/prove_by_invariants.hpp"
#include "runtime/core/core.hpp"

namespace bip::verify {

enum class SearchEnd : std::uint8_t { Found, Exhausted, Limit };
/// What is looked for: states without candidate, states that satisfy something, steps that end in a run-time error.
struct SearchGoal {
  bool stuck = false, faults = false;
  std::function<bool(const rt::Core&)> state;
};
struct SearchResult {
  SearchEnd end = SearchEnd::Limit;
  std::vector<std::uint64_t>
      choices;  // Found: the numbers of the candidates taken; the last one ends in the error, if that is the goal
  std::uint64_t states = 0;  // different ones visited
  std::string fault;         // one line of a run-time error that was met; empty: none
  std::string limit;         // Limit: which
};

struct SearchLimits {
  CancellationToken cancellation;
  std::size_t megabytes = 2048;
  std::uint64_t states = ~std::uint64_t{0};
  bool only_walk = false;                            // towards the candidate, no more
  std::function<void(std::uint64_t states)> report;  // called now and then; may be empty
  std::function<void(const rt::State&)> visit = {};  // called for each different state; may be empty
};

/// `candidate`: by atom the mode to head for; empty: none is known. The image must have its code.
[[nodiscard]] SearchResult search(const Net& net, const rt::Image& image, const SearchGoal& goal,
                                  const std::vector<u32>& candidate, const SearchLimits& limits);

/// Equal for equal states only; of images without FFI data and time.
[[nodiscard]] std::string state_key(const rt::State& state);

/// Do these steps lead from the initial state to the goal?
[[nodiscard]] bool reaches(const rt::Image& image, const SearchGoal& goal, const std::vector<std::uint64_t>& choices);

}  // namespace bip::verify
