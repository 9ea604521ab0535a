// Looks for a real deadlock with the engine's own core: first a walk towards the candidate, then every state, best first.
//
// A deadlock that is returned has been replayed from the initial state. Exhausted means that every reachable state was
// visited (the core decides what that is), so that there is no deadlock. States are kept in memory up to a bound.
#pragma once
#include <string>

#include "compiler/verify/prove.hpp"
#include "runtime/core/core.hpp"

namespace bip::verify {

enum class SearchEnd : std::uint8_t { Deadlock, Exhausted, Limit };
struct SearchResult {
  SearchEnd end = SearchEnd::Limit;
  std::vector<std::uint64_t> choices;  // Deadlock: the numbers of the candidates taken
  std::uint64_t states = 0;            // different ones visited
  std::string fault;                   // one line of a run-time error that was met; empty: none
  std::string limit;                   // Limit: which
};

struct SearchLimits {
  Clock::time_point end;
  std::size_t megabytes = 2048;
  bool only_walk = false;  // towards the candidate, no more
};

/// `candidate`: by atom the mode to head for; empty: none is known. The image must have its code.
[[nodiscard]] SearchResult search_deadlock(const Net& net, const rt::Image& image, const std::vector<u32>& candidate,
                                           const SearchLimits& limits);

/// The steps as text, then who waits for whom. False: the choices do not lead to a deadlock.
[[nodiscard]] bool tell_deadlock(const rt::Image& image, const std::vector<std::uint64_t>& choices, std::size_t max_lines,
                                 std::string& out);

}  // namespace bip::verify
