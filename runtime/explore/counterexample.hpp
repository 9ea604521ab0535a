// The result of an exploration as text. A counterexample is replayed by a core from the initial state before it is
// printed. The last line of all reports is written here as well.
#pragma once
#include <string>

#include "bip/run.hpp"
#include "runtime/explore/explore.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::rt {

/// "complete", "limit", "memory", "time", "interrupted".
[[nodiscard]] const char* name_of(ExploreEnd end);
/// `explored: 82 reachable states, 205 steps, 1 deadlock, 0 errors`, with `limit:` … and `at least` if it is partial.
[[nodiscard]] std::string summary_line(const ExploreReport& report);
/// The published engine's: ` found 82 reachable states, 1 deadlock, and 0 error`. Before it go kPublishedBegin and the
/// dots.
[[nodiscard]] std::string published_line(const ExploreReport& report);
inline constexpr const char* kPublishedBegin =
    "[BIP ENGINE]: initialize components...\n[BIP ENGINE]: computing reachable states: ";
/// A sign of life in that form: one dot for so many states.
inline constexpr u64 kStatesPerDot = 1000;
/// "3 states", "1 state".
[[nodiscard]] std::string counted(u64 n, const char* what);

/// `explored: 20 zones of 7 locations, 31 steps, 0 deadlocks, 1 time lock, 0 errors`
[[nodiscard]] std::string summary_line(const ZoneReport& report);

enum class CounterexampleEnd : std::uint8_t { Deadlock, Error, TimeLock, State };
/// A path of a report, which owns it, and how it ends.
struct FoundPath {
  CounterexampleEnd end = CounterexampleEnd::Deadlock;
  const TimedPath* path = nullptr;  // null: no violation was found
};
/// Returns the deadlock that was found, else the time lock, else the error.
[[nodiscard]] FoundPath first_of(const ZoneReport& found);
/// Returns a path without time as one whose steps are all taken at once.
[[nodiscard]] TimedPath at_once(const Path& path);

struct CounterexampleText {
  std::string names;  // of the candidates taken, "ROOT.a, ROOT.b"
  std::string steps;  // one line per step; Deadlock: then the wait-for cycle
  std::string error;  // Error, TimeLock: the run-time error
};
/// Replays a path from the initial state and returns its text, with at most max_lines steps. O(steps).
[[nodiscard]] CounterexampleText describe_counterexample(const Image& image, MaximalProgress progress,
                                                         CounterexampleEnd end, const Path& path,
                                                         std::size_t max_lines);
[[nodiscard]] CounterexampleText describe_counterexample(const Image& image, MaximalProgress progress,
                                                         CounterexampleEnd end, const TimedPath& path,
                                                         std::size_t max_lines);
/// Returns the path as a trace: the lines that `bipc replay --published` reads (Bip2), else JSON lines.
[[nodiscard]] std::string trace_of_counterexample(const Image& image, MaximalProgress progress, const Path& path,
                                                  TraceFormat format);
[[nodiscard]] std::string trace_of_counterexample(const Image& image, MaximalProgress progress, CounterexampleEnd end,
                                                  const TimedPath& path, TraceFormat format);

/// Returns the path as one object of JSON: `{"run":[…],"state":{…}}`, the steps as in a trace (JSON lines), places and
/// data of each component in the last state; of a deadlock also `waits` and, if there is one, `wait_cycle`, of an error
/// `error`. O(steps and components).
[[nodiscard]] std::string counterexample_json(const Image& image, MaximalProgress progress, CounterexampleEnd end,
                                              const TimedPath& path);

}  // namespace bip::rt
