// All behaviours of a timed image at all instants: its zone graph (Daws, Tripakis 1998; Bengtsson, Yi 2004), breadth
// first.
//
// A state of the graph is a *location* (markings, data, busy atoms) with a zone of clock values. Time is the core's:
// whole ticks, so zones are exact, and what is enabled in a part of a zone in which no condition changes its truth is
// asked of a core at one point of it. Deadlock: no candidate now, and none however long time passes. Time lock: no
// candidate, and time may not pass. A lazy step may be missed; a state in which it was counts. Not exact, and then
// ended with the reason: clocks that run at another speed than 1. Conditions on differences of clocks are exact too,
// but nothing is forgotten then, so the graph may have no end. Cost: zones times interactions times clocks squared; a
// location's zones are compared pairwise.
#pragma once
#include <optional>

#include "runtime/explore/dbm.hpp"
#include "runtime/explore/explore.hpp"

namespace bip::rt {

struct TimedStep {
  i64 at = 0;      // the instant
  u64 choice = 0;  // number of the candidate at that instant
};
/// An atom whose `resume` waits goes on.
struct Resumption {
  u64 before = 0;  // the step of this number; their count: the end
  u32 atom = 0;
  i64 at = 0;  // the instant
};
/// From the initial state. `end`: the instant to which time passes afterwards. A busy atom without a resumption stays
/// busy.
struct TimedPath {
  std::vector<TimedStep> steps;
  i64 end = 0;
  std::vector<Resumption> resumptions = {};  // by step and instant
};

struct ZoneReport {
  ExploreEnd end = ExploreEnd::Complete;
  std::string inexact;  // what could not be followed, with its place; the exploration ended there
  u64 zones = 0, locations = 0, steps = 0;
  u64 finals =
      0;  // locations whose atoms are all at final places, and where time may pass for ever without a candidate
  bool has_final_states = false;                  // each atom declares final places
  u64 deadlocks = 0, time_locks = 0, errors = 0;  // zones with such a point; with a step that ends in a run-time error
  u32 depth = 0;
  bool has_deadlock = false, has_time_lock = false, has_error = false;
  bool has_match = false;     // options.predicate was true somewhere: the exploration ended there
  std::vector<u32> stuck;     // of explore_local_deadlocks: these atoms, at the end of `match`
  bool is_match_end = false;  // of a response: the run ends there, at a time lock
  // Of a response without a limit: the steps of `match` from this number on repeat for ever. None of them: time passes
  // for ever after the last one, or is_match_end.
  std::optional<u64> match_cycle = std::nullopt;
  // The same: steps can repeat for ever while time stands still. Such runs do not count.
  bool has_standing_cycle = false;
  // The same, once locations have been visited: see ListedLocation::ranks. `returning`: ranks, each with an atom.
  i64 later = 0;
  std::vector<std::pair<u32, u32>> returning = {};
  TimedPath deadlock, time_lock, error, match;
  bool are_paths_known = true;  // false: the core could not take a path
  std::size_t bytes = 0;
  double seconds = 0;
};

/// One thread. options.reduction and threads mean nothing here; options.limit counts zones.
[[nodiscard]] ZoneReport explore_zones(const Image& image, const ExploreOptions& options);

/// A location of a zone graph with its zones. `waits`: by atom 0, or the transition whose `resume` it waits for, by its
/// number + 1; after `initial`: the number of transitions + 1. `leaders`: with whom it goes on then.
struct ListedLocation {
  const State* state = nullptr;  // its `time` is of no meaning
  std::vector<u32> waits, leaders;
  std::vector<const Zone*> zones;
  bool is_pending = false;  // of a response: a request waits; the last clock is that of the observer
  // Of a response without a limit, where a request waits, by zone. While the same request waits, ranks never rise; and
  // with a step at which the observer's clock has reached ZoneReport::later, where it begins again, they fall. Of a
  // rank in ZoneReport::returning, with an atom, they fall with the return of its action; before such a step, which
  // leaves the rank as it is, the action may return. (Where it may at infinitely many instants it does.)
  std::vector<u32> ranks = {};
};
/// The same; visits all locations that have zones, in the order of finding, if the graph is complete and the predicate
/// holds nowhere. The set of these points is closed under steps and under time, but for steps that end in an error.
[[nodiscard]] ZoneReport explore_zones(const Image& image, const ExploreOptions& options,
                                       const std::function<void(const ListedLocation&)>& visit);

/// The same, for local deadlocks: has_match says that at the end of `match` an atom wants to move (wants_to_move of
/// runtime/core/final_state.hpp) and never does, in no run that goes on from there. What is ahead of the points of a
/// zone is computed backwards along the graph's edges, for one atom after the other, once the graph is complete; a step
/// that ends in an error moves those who take part in it. Cost: that of the graph, and for each atom about as much
/// again.
[[nodiscard]] ZoneReport explore_local_deadlocks(const Image& image, const ExploreOptions& options);

/// A demand: at most `within` ticks after each point of a run at which `request` is true `response` is true. A point is
/// a state while time passes in it (no candidate), or a step that is taken from it. What they read does not change
/// while time passes. Without a limit `response` is true at some time in each run in which time passes for ever, and
/// before each time lock.
struct TimedResponse {
  std::function<bool(Core&, const Candidate*)> request, response;
  bool asks_once = false;  // the first point of a run is the only request, and `request` is not called
  std::optional<i64> within = 0;
};
/// The zone graph with an observer: has_match says that a run misses the demand, `match` leads to the first instant
/// after the limit, or to a time lock before it. The core has taken it, or are_paths_known is false. A run without a
/// further instant beyond the limit that goes on for ever (Zeno) misses nothing.
///
/// Without a limit: `match` leads to a time lock, to where time may pass for ever without a step, or once around a
/// cycle (match_cycle). Zones of which a request waits are then kept apart unless they are equal, so there are more of
/// them. An action that may return (`resume`) does so some time.
[[nodiscard]] ZoneReport explore_response(const Image& image, const ExploreOptions& options,
                                          const TimedResponse& response);
/// The same; visits all locations that have zones if the graph is complete and no run misses the demand.
[[nodiscard]] ZoneReport explore_response(const Image& image, const ExploreOptions& options,
                                          const TimedResponse& response,
                                          const std::function<void(const ListedLocation&)>& visit);
/// Where a path misses the demand.
struct MissedResponse {
  bool is_missed = false;
  i64 requested = 0;     // the instant
  u64 requested_by = 0;  // steps taken until then
  bool at_step = false;  // requested by the step of this number
};
[[nodiscard]] MissedResponse follow_response(const Image& image, const ExploreOptions& options, const TimedPath& path,
                                             const TimedResponse& response);

/// A monitor of what has been, as bits. `next` reads a point of a run (as those of TimedResponse) and the bits that the
/// point before left, 0 before the first one; of a point without a candidate it may be asked any number of times.
/// `is_violated` stays true once it is.
struct TimedMonitor {
  std::function<u64(Core&, const Candidate*, u64 before)> next;
  std::function<bool(u64)> is_violated;
};
/// The zone graph with a monitor: has_match says that a run violates it, and `match` leads there. The core has taken
/// it, or are_paths_known is false. What ends in an error at the step that would violate it is not looked at.
[[nodiscard]] ZoneReport explore_monitor(const Image& image, const ExploreOptions& options,
                                         const TimedMonitor& monitor);

/// An image that stands for a part of a system whose other components may do anything
/// (compiler/verify/timed/localization.hpp), and one component of it: is there an instant to which its invariants hold
/// time up and at which no step of the part alone can be taken?
struct PartQuestion {
  u32 atom = 0;
  std::vector<std::uint8_t>
      is_whole;  // by connector: a candidate in the part is one in the whole; so are internal ports
  std::function<bool(const Core&)> is_impossible;  // no state of the whole has these markings and data; asked once each
  std::function<bool(const Core&)> is_asked;       // only there; empty: everywhere
  bool asks_places = false;                        // else: is there a state where is_asked says so, whatever time does?
  // All locations that have zones, in the order of finding, if the graph is complete and nothing was open.
  std::function<void(const Image&, const ListedLocation&)> visit = {};
};
struct PartReport {
  bool is_complete = false;  // all zones were seen, or an open one was found
  bool is_open = false;      // there is such an instant, as far as the part knows
  State open;                // the markings and data there
  std::string inexact;
  u64 zones = 0, locations = 0, impossible = 0;
};
[[nodiscard]] PartReport explore_part(const Image& image, const ExploreOptions& options, const PartQuestion& question);

/// Lets time pass to an instant. False: it may not pass so far, or a fault.
[[nodiscard]] bool let_time_pass(Core& core, i64 to);
/// Lets time pass to the path's step of this number, or to its end; in between busy atoms go on as the path says. The
/// core has just been initialized, or has taken the step before. False: as above.
[[nodiscard]] bool let_time_pass(Core& core, const TimedPath& path, u64 number);

}  // namespace bip::rt
