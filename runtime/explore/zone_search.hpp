// One exploration of a zone graph. Internal to runtime/explore; what it computes is in zones.hpp.
//
// A node is a location with a zone that lies in one cell (zone_location.hpp) and is closed under the time that may pass
// in it. Its edges: a step; time that goes on into a neighbour cell; atoms that stop being busy, which takes no time
// and comes first.
#pragma once
#include <chrono>
#include <deque>

#include "runtime/explore/zone_location.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::rt {

enum class ZoneEdge : std::uint8_t { Initial, Step, Time, GoOn };

struct ZoneNode {
  u32 location = 0, parent = kNone, depth = 0;
  ZoneEdge edge = ZoneEdge::Initial;
  InteractionId interaction{0u};
  u32 config = 0;             // Step
  bool is_still = false;      // no time passes in it
  bool is_faulty = false;     // a run that comes here ends in an error
  bool is_waking = false;     // busy atoms may go on
  bool is_covered = false;    // by a later one, before it was expanded
  bool is_requested = false;  // a request begins to wait, and the observer's clock
  bool is_later = false;      // Step, without a limit: the observer's clock shows that time has passed, and begins
  u32 covered_by = kNone;     // is_covered: the node that takes its place
  std::vector<i64> origin;    // Step: a point of the parent's zone at which it was taken
  Zone zone;
};

/// Of a search for local deadlocks: what may happen at points of a node.
struct ZoneMove {
  u32 from = 0;
  ZoneEdge edge = ZoneEdge::Step;
  Zone part;                              // these points; Time: those a tick later
  std::vector<std::pair<u32, i64>> sets;  // Step: clocks, and their values afterwards
  std::vector<u32> atoms;                 // Step: those who move
  std::vector<u32> to;                    // nodes that have the points to which it leads; none: an error
};

/// Of a response without a limit: from a node to one that follows, while the same request waits.
struct ZoneArc {
  u32 from = 0, to = 0;
  ZoneEdge edge = ZoneEdge::Step;
  bool is_later = false;
  InteractionId interaction{0u};
  u32 config = 0;
  std::vector<i64> origin;
};

class ZoneSearch {
 public:
  ZoneSearch(const Image& image, const ExploreOptions& options, const PartQuestion* part = nullptr,
             const TimedResponse* response = nullptr, const TimedMonitor* monitor = nullptr);
  ZoneReport run();
  ZoneReport run_for_local_deadlocks();
  /// After it, if the graph is complete and there is no match: all locations that have zones.
  void visit_locations(ZoneReport& report, const std::function<void(const ListedLocation&)>& visit);
  PartReport run_part();
  /// After it: the graph.
  [[nodiscard]] const std::deque<ZoneNode>& nodes() const { return nodes_; }
  [[nodiscard]] Locations& locations() { return locations_; }

 private:
  struct Target {  // what was found first
    u32 node = kNone;
    std::vector<i64> point;
    bool is_error = false, is_step = false;  // is_step: in a step of this interaction
    InteractionId interaction{0u};
    u32 config = 0;
    bool is_far = false;           // deadlock: however long time passes
    bool is_state = false;         // it is enough to be there
    bool is_bound = false;         // just there: at an open bound
    bool is_idle = false;          // is_far, and steps are possible that need not be taken
    std::vector<u32> arcs = {};    // followed from the node on, back to it
    const Zone* within = nullptr;  // the end is one of these points
  };
  // How a path enters a node.
  struct Visit {
    u32 node = 0, parent = kNone;
    ZoneEdge edge = ZoneEdge::Initial;
    InteractionId interaction{0u};
    u32 config = 0;
    bool is_requested = false, is_later = false;
    const std::vector<i64>* origin = nullptr;
  };
  // zone_search.cpp
  bool begin();
  void search();
  void sum_up();
  void expand(u32 node);
  void enter(u32 location, Zone&& zone, ZoneNode&& label);
  void insert(ZoneNode&& node);
  bool step_from(u32 node, const InteractionCondition& condition, std::vector<Zone>& rest);
  bool fire(u32 node, const Zone& cell, const std::vector<i64>& point, u64 k);
  [[nodiscard]] std::vector<Zone> cells_ahead(u32 node);
  [[nodiscard]] std::vector<Zone> take_closed(u32 node, std::vector<Zone>& ahead);
  void pass_time(u32 node, std::vector<Zone>& ahead);
  void go_on(u32 node);
  enum class ErrorIn : std::uint8_t { Step, State };  // while firing, or already when the core looks at the state
  void note_error(u32 node, const std::vector<i64>& point, ErrorIn where, InteractionId interaction, u32 config);
  [[nodiscard]] bool is_over();
  bool follow_clocks(Zone& zone);
  [[nodiscard]] bool enter_core(const Location& at, const std::vector<i64>& point) {
    return core_.restore(locations_.point(at, point));
  }
  [[nodiscard]] bool is_inside(const Location& at, const Zone& zone) const;
  [[nodiscard]] static bool wakes(const WaitGroup& group, const Zone& zone);
  [[nodiscard]] bool wakes(const Location& at, const Zone& zone) const;
  [[nodiscard]] std::vector<Zone> without_last(u32 node, std::vector<Zone> zones);
  [[nodiscard]] bool is_eager(const Location& at, const std::vector<i64>& point);
  [[nodiscard]] bool is_faulty(const Location& at, const std::vector<i64>& point);
  [[nodiscard]] Bounds deadlines(const Location& at, const std::vector<i64>& point);

  // zone_predicate.cpp
  [[nodiscard]] bool find_match(u32 node);
  void classify_dead_points(u32 node, const std::vector<Zone>& rest, const std::vector<Zone>& ends);
  // zone_response.cpp
  /// What the observer makes of a point: the request that waited may have its response, or one begins to wait.
  void observe(const Candidate* candidate, bool& is_pending, bool& is_requested);
  [[nodiscard]] bool find_late(u32 node);
  [[nodiscard]] bool is_without_limit() const { return response_ != nullptr && !response_->within; }
  // zone_monitor.cpp
  [[nodiscard]] bool find_violated(u32 node);
  // zone_lasso.cpp
  void note_arc(const ZoneNode& to, u32 row);
  void enter_later(u32 location, const Zone& zone, const ZoneNode& label);
  [[nodiscard]] bool find_idle(u32 node);
  void find_lasso();
  /// By node, of a complete graph without a lasso: see ListedLocation::ranks.
  [[nodiscard]] std::vector<u32> ranks(ZoneReport& report) const;
  static constexpr u32 kFirstLook = 1024;  // nodes
  [[nodiscard]] bool may_go_on(u32 node, u32 atom);
  // zone_local_deadlock.cpp
  /// Records a ZoneMove for as long as the object lives: insert() adds the nodes to which it leads. Does nothing unless
  /// notes_moves_ is set.
  class NotedMove;
  void note_arrival(u32 node);
  void find_local_deadlock();
  [[nodiscard]] std::vector<i64> point_of_core() const;
  // zone_part.cpp
  [[nodiscard]] bool is_impossible(u32 row);
  [[nodiscard]] bool is_asked_for(u32 node);
  [[nodiscard]] bool is_held_up(const Location& at, const std::vector<Zone>& rest);

  // zone_counterexample.cpp
  void find_path(const Target& target, TimedPath& path);
  [[nodiscard]] std::vector<Visit> visits_of(const Target& target) const;

  const Image& image_;
  ExploreOptions options_;
  Core core_;
  Locations locations_;
  const PartQuestion* part_;                          // not null: the image is a part of a system
  const TimedResponse* response_;                     // not null: an observer runs beside it
  const TimedMonitor* monitor_;                       // likewise
  IndexVector<InteractionId, std::uint8_t> is_sure_;  // of a part: a candidate is one in the whole
  u32 open_ = kNone;                                  // of a part: a location
  u64 impossible_ = 0;
  std::deque<ZoneNode> nodes_;
  std::vector<ZoneArc> arcs_;  // of a response without a limit
  std::vector<u32> refused_;   // by strong component of them: an atom whose action may return and never does, or kNone
  bool notes_moves_ = false;
  std::vector<ZoneMove> moves_;
  u32 move_ = kNone;   // the one that is made
  u32 next_ = 0;       // the first that was not expanded
  u32 next_look_ = 0;  // at arcs, when this node has been expanded; then twice as late
  std::size_t node_bytes_ = 0;
  Target deadlock_, time_lock_, error_, match_;
  bool is_node_faulty_ = false;
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  ZoneReport report_;
};

/// Empty, or what of the model has no exact zones, with its place (unfollowed.cpp).
[[nodiscard]] std::string what_zones_cannot_follow(const Image& image);
/// The parts of the zone in each of which every bound is true or false throughout.
[[nodiscard]] std::vector<Zone> cut(const Zone& zone, const Bounds& bounds);
/// Keeps the points that agree with `part` (a cell of them) on every bound. False: there are none.
[[nodiscard]] bool agree(Zone& zone, const Zone& part, const Bounds& bounds);

}  // namespace bip::rt
