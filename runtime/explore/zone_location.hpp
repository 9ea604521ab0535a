// The discrete half of a timed state, and what it demands of the clocks. Internal to runtime/explore.
//
// A condition is a list of bounds (dbm.hpp). For each interaction the list says what its candidates depend on; those of
// urgent interactions, and what busy atoms wait for, cut a zone into cells in each of which the passing of time is
// ruled alike.
#pragma once
#include <deque>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "runtime/explore/dbm.hpp"
#include "runtime/explore/explore.hpp"
#include "runtime/explore/shapes.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::rt {

using Bounds = std::vector<ZoneBound>;

struct InteractionCondition {
  InteractionId interaction{0u};
  bool is_conjunction = false;  // a candidate exactly where all bounds hold
  Bounds bounds;
};
/// Atoms that go on together once all bounds hold.
struct WaitGroup {
  u32 leader = 0;
  bool ends = true;  // false: never
  Bounds bounds;
};
/// What an observer beside the zone graph knows of the run that led to a location.
struct Observed {
  bool is_pending = false;  // a request waits for its response (TimedResponse)
  u64 past = 0;             // TimedMonitor
};
struct Location {
  State state;               // its `time` is of no meaning
  std::vector<u32> waits;    // by atom: the transition after which it is busy, kInitial, or kNone
  std::vector<u32> leaders;  // by atom: with whom it goes on
  Observed observed;
  bool is_measured = false;
  // Of a location of a part (PartQuestion): may the whole system be in it?
  enum class Feasibility : std::uint8_t { NotDecided, Possible, Impossible };
  Feasibility in_whole = Feasibility::NotDecided;
  bool is_final = false;  // each atom is at final places
  bool may_go_on = true;  // false: an invariant holds nowhere
  Bounds invariants;
  std::vector<InteractionCondition> interactions;
  std::vector<WaitGroup> groups;
  Bounds cells;  // sorted
  Bounds asked;  // in a part that they cut, what is asked of candidates and ports has one answer; sorted
  bool has_urgent = false;
  std::vector<u32> nodes;  // of the zone graph

  /// What it holds, with what the allocator adds.
  [[nodiscard]] std::size_t bytes() const;
};
inline constexpr u32 kAfterInitial = kNone - 1;

class Locations {
 public:
  /// `response`: may be null; else the last clock is the observer's, which measures the oldest request.
  Locations(Core& core, const ExploreOptions& options, const TimedResponse* response);

  /// The row of the location; made if it is new.
  u32 find_or_add(State&& state, const std::vector<u32>& waits, const std::vector<u32>& leaders,
                  const Observed& observed);
  [[nodiscard]] Location& operator[](u32 row) { return rows_[row]; }
  [[nodiscard]] u32 size() const { return static_cast<u32>(rows_.size()); }
  void clear();
  /// Of all locations, those that are measured as they are then; without `Location::nodes`.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

  /// Works out what the location demands, at clock values that it is reached with. False: a guard of an atom faults.
  [[nodiscard]] bool measure(Location& at, const std::vector<i64>& clocks);
  /// A state of the core: the location with these clock values ([0] unused).
  [[nodiscard]] State point(const Location& at, const std::vector<i64>& clocks) const;
  /// The bounds of the atom's transitions, in the core's state.
  [[nodiscard]] Bounds bounds_of(u32 atom);
  /// All bounds that matter at the location.
  [[nodiscard]] Bounds all_bounds(const Location& at) const;

  [[nodiscard]] u32 clocks() const { return clocks_; }
  /// The observer's clock has passed this bound: the response is late. Of a response without a limit: the clock has
  /// reached it, so time has passed.
  [[nodiscard]] const ZoneBound& in_time() const { return in_time_; }
  /// By clock + 1: compared with nothing greater, never set to less.
  [[nodiscard]] const std::vector<i64>& max() const { return max_; }
  [[nodiscard]] const std::vector<i64>& min() const { return min_; }
  /// Has a constant grown since? What was forgotten before may matter then.
  [[nodiscard]] bool take_growth() { return std::exchange(has_grown_, false); }
  void note_set(u32 clock, i64 value);
  /// A guard faults at some instants of a location: from now on all conditions cut zones into cells, so that the time
  /// that passes ends where the run would.
  void cut_by_all() {
    has_grown_ = has_grown_ || !is_cut_by_all_;
    is_cut_by_all_ = true;
  }
  [[nodiscard]] bool is_cut_by_all() const { return is_cut_by_all_; }
  [[nodiscard]] bool has_differences() const { return has_differences_; }
  [[nodiscard]] const Shapes& shapes() const { return shapes_; }

 private:
  void append(u32 atom, const MeasuredGuard& guard, Bounds& out);
  bool measure_bounds(Location& at, const std::vector<i64>& clocks);
  void measure_asked(Location& at);
  void note(const ZoneBound& bound);
  bool measure_interaction(Location& at, InteractionId interaction);

  Core& core_;
  Shapes shapes_;
  u32 clocks_ = 0;
  ZoneBound in_time_;                          // of the observer's clock; 0, 0: there is none
  bool is_limited_ = false;                    // the observer's clock cuts cells
  i64 divisor_ = 0;                            // of the constants that were noted, but for open bounds
  std::vector<bool> is_timed_;                 // by atom
  IndexVector<InteractionId, bool> is_ruled_;  // priorities compare it with others
  std::vector<u32> ruled_atoms_;               // of all those interactions
  std::vector<InteractionId> asked_interactions_;
  std::vector<u32> asked_atoms_;
  std::vector<VariableId> unread_cells_;
  std::vector<i64> max_, min_;
  bool has_grown_ = false, has_differences_ = false, is_cut_by_all_ = false;
  std::deque<Location> rows_;
  std::unordered_map<std::string, u32> index_;
  std::size_t bytes_ = 0;
  std::vector<std::vector<TimedTransition>> transitions_;  // by atom, of the location that is measured
};

}  // namespace bip::rt
