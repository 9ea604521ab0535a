// All reachable stable states of an image, breadth first, on several threads: how many there are, and a shortest way to
// a deadlock, to a run-time error and to a state that is asked for.
//
// Exact: every state is stored, no hash decides alone. Successors are the core's (expander.hpp). Counts, depths and the
// ways told are the same with any number of threads: of all shortest ways to a deadlock (an error) the one is told that
// is first in the order of candidates. Memory: 14 to 19 bytes a state if it fits 64 bits, plus what the frontier's
// successors need for a moment. The limits are kept: what is known when one is met is told, marked as partial.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "runtime/core/core.hpp"

namespace bip::rt {

enum class Reduction : std::uint8_t { None, Por, Symmetry };

struct ExploreProgress {
  u64 states = 0, expanded = 0, steps = 0, deadlocks = 0, errors = 0, broken = 0;
  u32 depth = 0;
  std::size_t bytes = 0;
};
struct ExploreOptions {
  MaximalProgress progress = MaximalProgress::On;
  Reduction reduction = Reduction::None;
  u64 limit = ~u64{0};    // states; with a limit one thread works
  double seconds = 0;     // 0: no limit
  std::size_t bytes = 0;  // of everything that is kept; 0: no limit
  u32 threads = 1;
  std::function<void(const ExploreProgress&)> tell;  // now and then
  std::function<bool()> is_stopped;                  // asked now and then, by any thread
  std::function<bool(const Core&)>
      is_broken;  // states that are looked for, by any thread; zones: the search ends at such an instant
  std::vector<u32> asked_connectors,
      asked_atoms;              // whose candidates and whose ports it asks for; else it is about places and data alone
  std::vector<u32> read_atoms;  // without zones: all atoms that it is about, unless it asks for connectors
};

enum class ExploreEnd : std::uint8_t { Complete, States, Memory, Time, Stopped };

/// A way from the initial state: numbers of candidates, each among those of its state.
using Way = std::vector<u64>;

struct ExploreReport {
  ExploreEnd end = ExploreEnd::Complete;
  u64 states = 0, steps = 0, deadlocks = 0;
  u64 errors = 0;  // states with a step that ends in a run-time error
  u32 depth = 0;   // steps to the state that is farthest
  bool has_deadlock = false, has_error = false, has_broken = false;
  Way deadlock;                // to the state
  Way error;                   // the last step ends in the fault; empty: the initial state does
  Way broken;                  // to the state
  bool are_ways_known = true;  // false: time or memory ran out while they were looked for
  std::size_t bytes = 0;       // of states alone
  u32 bits = 0, words = 0;     // of a state
  u32 threads = 1;
  double seconds = 0;
  std::vector<std::string> groups;  // Symmetry: what is interchangeable
};

/// Por and Symmetry: a reason why the image cannot be explored so, or empty. Both may leave out states that `is_broken`
/// looks for.
[[nodiscard]] std::string reduction_problem(const Image& image, const ExploreOptions& options);

/// The image has its code. With C++ in the model one thread works and equal states are taken to behave equally.
[[nodiscard]] ExploreReport explore_states(const Image& image, const ExploreOptions& options);

}  // namespace bip::rt
