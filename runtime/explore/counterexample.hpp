// What an exploration found, as text: ways by a core that takes them from the initial state, so that what is told has
// been replayed; the last line that all reports share.
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

enum class WayEnd : std::uint8_t { Deadlock, Error, TimeLock, State };
struct ToldWay {
  std::string names;  // of the candidates taken, "ROOT.a, ROOT.b"
  std::string steps;  // a line a step; Deadlock: then who waits for whom
  std::string error;  // Error, TimeLock: the run-time error
};
/// Takes the way. At most max_lines steps are listed.
[[nodiscard]] ToldWay tell_way(const Image& image, MaximalProgress progress, WayEnd end, const Way& way,
                               std::size_t max_lines);
[[nodiscard]] ToldWay tell_way(const Image& image, MaximalProgress progress, WayEnd end, const TimedWay& way,
                               std::size_t max_lines);
/// The way as a trace that `bipc replay` reads (Bip2) or JSON lines.
[[nodiscard]] std::string trace_of_way(const Image& image, MaximalProgress progress, const Way& way,
                                       TraceFormat format);
[[nodiscard]] std::string trace_of_way(const Image& image, MaximalProgress progress, WayEnd end, const TimedWay& way,
                                       TraceFormat format);

}  // namespace bip::rt
