// All reachable stable states of an image, breadth first, on several threads: how many there are, and a shortest path
// to a deadlock, to a run-time error and to a state where a predicate holds.
//
// Exact: every state is stored, no hash decides alone. Successors are the core's (expander.hpp). Counts, depths and the
// reported paths are the same with any number of threads: of all shortest paths to a deadlock (an error) the one that
// is first in the order of candidates. Memory: 14 to 19 bytes a state if it fits 64 bits, plus what the frontier's
// successors need for a moment. Limits are kept: a report that a limit ended has what is known then, marked as partial.
#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "runtime/core/core.hpp"

namespace bip::rt {

/// Partial order reduction (stubborn sets), or symmetry reduction.
enum class StateReduction : std::uint8_t { None, Por, Symmetry };

struct ExploreProgress {
  u64 states = 0, expanded = 0, steps = 0, deadlocks = 0, errors = 0, matches = 0;
  u32 depth = 0;
  std::size_t bytes = 0;
};
/// Atoms that change places: by atom, the other one.
using AtomExchange = std::map<u32, u32>;
/// What restricts the exchanges of components that symmetry reduction uses.
struct SymmetryLimits {
  // Does the predicate hold in a state exactly if it holds after this exchange? Empty: after each. The connectors that
  // it reads are given apart: they are mapped to themselves.
  std::function<bool(const AtomExchange&)> preserves_predicate;
  std::vector<u32> named_atoms;       // that the predicate names, ascending: these are expected to be individuals
  std::vector<u32> fixed_connectors;  // that the predicate names
  u64 work = ~u64{0};                 // numbers that are compared; beyond, nothing is interchangeable
  u64 work_per_exchange = 0;          // of preserves_predicate
};
struct ExploreOptions {
  MaximalProgress progress = MaximalProgress::On;
  StateReduction reduction = StateReduction::None;
  u64 limit = ~u64{0};    // states; with a limit one thread works
  double seconds = 0;     // 0: no limit
  std::size_t bytes = 0;  // of everything that is stored; 0: no limit
  u32 threads = 1;
  std::function<void(const ExploreProgress&)> on_progress;  // called after each batch, by one thread
  std::function<bool()> is_stopped;                         // called every few states, by any thread
  // Holds in the states that are searched for; called by any thread. Zones: the search ends at such an instant.
  std::function<bool(const Core&)> predicate;
  // What the predicate reads. Connectors and atoms whose candidates and enabled ports it reads; without any it reads
  // places and data alone.
  std::vector<u32> predicate_connectors, predicate_atoms;
  std::vector<u32> predicate_reads;  // without zones and connectors: all atoms that it reads
  SymmetryLimits symmetry;           // of StateReduction::Symmetry
  // Rows of the cells of data on which nothing depends but themselves: states that differ in these alone count as one.
  // The predicate reads none of them.
  std::vector<VariableId> unread_cells;
};

enum class ExploreEnd : std::uint8_t { Complete, States, Memory, Time, Stopped };

/// A path from the initial state: numbers of candidates, each among those of its state.
using Path = std::vector<u64>;
/// In a model that draws random numbers, a number of a path also says which values are drawn (DrawScript): from bit 32
/// on.
[[nodiscard]] constexpr u64 candidate_of(u64 choice) { return choice & 0xffffffffu; }
[[nodiscard]] constexpr u64 drawn_by(u64 choice) { return choice >> 32; }
[[nodiscard]] constexpr u64 choice_of(u64 candidate, u64 drawn) { return candidate | drawn << 32; }

struct ExploreReport {
  ExploreEnd end = ExploreEnd::Complete;
  u64 states = 0, steps = 0, deadlocks = 0;
  u64 finals = 0;                 // final states: no step, and no deadlock
  bool has_final_states = false;  // each atom declares final places
  u64 errors = 0;                 // states with a step that ends in a run-time error
  u32 depth = 0;                  // steps to the state that is farthest
  bool has_deadlock = false, has_error = false, has_match = false;
  Path deadlock;                // to the state
  Path error;                   // the last step ends in the fault; empty: the initial state does
  Path match;                   // to a state where the predicate holds
  bool are_paths_known = true;  // false: time or memory ran out during the search for paths
  std::size_t bytes = 0;        // of states alone
  u32 bits = 0, words = 0;      // of a state
  u32 threads = 1;
  double seconds = 0;
  std::vector<std::string> groups;  // Symmetry: what is interchangeable
};

/// Returns why the image cannot be explored with the reduction, or an empty text. Partial order reduction may leave out
/// states where the predicate holds; symmetry reduction too, unless `symmetry` says which exchanges preserve it.
[[nodiscard]] std::string reduction_problem(const Image& image, const ExploreOptions& options);
/// Members of arrays whose exchange is an automorphism of the system, by group and member their atoms, those of all
/// members of a group in one order; with time, too. Empty: none, or C++, priorities, or more work than the limits
/// allow.
[[nodiscard]] std::vector<std::vector<std::vector<u32>>> interchangeable_members(const Image& image,
                                                                                 const SymmetryLimits& limits);

/// Explores all reachable states of an image that has its code. With C++ in the model one thread works, and equal
/// states are taken to behave equally. Requires that reduction_problem() is empty. Time and memory: see above.
[[nodiscard]] ExploreReport explore_states(const Image& image, const ExploreOptions& options);

}  // namespace bip::rt
