// Local deadlocks with time: a point of the zone graph at which an atom wants to move, and from which no run moves it.
//
// For one atom, the points from which a run moves it are the least set that has those at which it takes part in a step,
// and those from which time, a step or a busy atom that goes on leads into the set. Sets are lists of zones by node;
// before a step lie the points that are in the set once the step has set their clocks (Bouajjani, Tripakis, Yovine
// 1997). All operations are exact, for time goes by ticks. A zone also has points that it only forgot to leave out:
// what can happen from such a point can happen from another one of the zone, but no path leads to it, so several are
// tried.
#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/explore/zone_search.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kMostPaths = 256;
constexpr u32 kNodesPerLook = 256;  // at the clock

void subtract_all(std::vector<Zone>& zones, const std::vector<Zone>& holes) {
  for (const Zone& hole : holes) {
    std::vector<Zone> left;
    for (const Zone& zone : zones) subtract(zone, hole, left);
    zones = std::move(left);
    if (zones.empty()) return;
  }
}

// For one atom: by node, the points from which a run moves it.
class PointsBefore {
 public:
  PointsBefore(const std::deque<ZoneNode>& nodes, const std::vector<ZoneMove>& moves)
      : nodes_(nodes), moves_(moves), into_(nodes.size()), points_(nodes.size()) {
    for (u32 row = 0; row < moves.size(); ++row) {
      for (u32 to : moves[row].to) {
        while (nodes[to].is_covered && nodes[to].covered_by != kNone) to = nodes[to].covered_by;
        into_[to].push_back(row);
      }
    }
  }

  // is_over: asked now and then, with the bytes of the zones. False: it was.
  template <class IsOver>
  bool find(u32 atom, const IsOver& is_over) {
    for (std::vector<Zone>& zones : points_) zones.clear();
    todo_.clear();
    bytes_ = 0;
    for (const ZoneMove& move : moves_) {
      if (std::find(move.atoms.begin(), move.atoms.end(), atom) != move.atoms.end()) add(move.from, move.part);
    }
    for (u32 count = 0; !todo_.empty(); ++count) {
      if (count % kNodesPerLook == 0 && is_over(bytes_)) return false;
      const auto [node, zone] = std::move(todo_.back());
      todo_.pop_back();
      bytes_ -= zone.bytes();
      for (const u32 row : into_[node]) step_back(moves_[row], zone);
    }
    return true;
  }
  [[nodiscard]] const std::vector<Zone>& at(u32 node) const { return points_[node]; }

 private:
  // With the time that leads to these points within the node.
  void add(u32 node, Zone zone) {
    if (!nodes_[node].is_still) {
      zone.let_time_precede();
      if (!zone.meet(nodes_[node].zone)) return;
    }
    std::vector<Zone>& known = points_[node];
    std::vector<Zone> rest{zone};
    subtract_all(rest, known);
    if (rest.empty()) return;
    std::erase_if(known, [&](const Zone& other) {
      if (!zone.includes(other)) return false;
      bytes_ -= other.bytes();
      return true;
    });
    known.push_back(zone);
    bytes_ += 2 * zone.bytes();
    todo_.emplace_back(node, std::move(zone));
  }

  void step_back(const ZoneMove& move, Zone zone) {
    switch (move.edge) {
      case ZoneEdge::Initial: return;
      case ZoneEdge::Step:
        for (const auto& [clock, value] : move.sets) {
          if (!zone.meet(ZoneBound{clock, 0, value}) || !zone.meet(ZoneBound{0, clock, -value})) return;
          zone.free_clock(clock);
        }
        if (!zone.meet(move.part)) return;
        break;
      case ZoneEdge::Time:
        if (!zone.meet(move.part)) return;
        zone.shift(-1);
        if (!zone.meet(nodes_[move.from].zone)) return;
        break;
      case ZoneEdge::GoOn:
        if (!zone.meet(move.part)) return;
        break;
    }
    add(move.from, std::move(zone));
  }

  const std::deque<ZoneNode>& nodes_;
  const std::vector<ZoneMove>& moves_;
  std::vector<std::vector<u32>> into_;     // by node: moves
  std::vector<std::vector<Zone>> points_;  // by node
  std::vector<std::pair<u32, Zone>> todo_;
  std::size_t bytes_ = 0;
};

}  // namespace

void ZoneSearch::note_arrival(u32 node) {
  if (move_ != kNone) moves_[move_].to.push_back(node);
}

void ZoneSearch::find_local_deadlock() {
  struct StuckPoints {
    u32 node, atom;
    Zone zone;
  };
  std::vector<StuckPoints> found;
  PointsBefore before(nodes_, moves_);
  const std::size_t graph_bytes = node_bytes_;
  const auto is_stopped = [&](std::size_t bytes) {
    node_bytes_ = graph_bytes + bytes;
    return is_over();
  };
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    if (!before.find(atom, is_stopped)) return;
    for (u32 node = 0; node < nodes_.size(); ++node) {
      if (nodes_[node].is_covered || nodes_[node].is_faulty) continue;
      const Location& at = locations_[nodes_[node].location];
      std::vector<Zone> rest{nodes_[node].zone};
      subtract_all(rest, before.at(node));
      // Who goes on at this instant at the latest does so before it can be said what is wanted.
      if (nodes_[node].is_waking) rest = without_last(node, std::move(rest));
      if (rest.empty() || !enter_core(at, rest[0].least_point())) continue;
      const Bounds bounds = locations_.bounds_of(atom);
      for (const Zone& zone : rest) {
        for (Zone& part : cut(zone, bounds)) {
          if (enter_core(at, part.least_point()) && wants_to_move(core_, atom))
            found.push_back({node, atom, std::move(part)});
        }
      }
    }
  }
  std::stable_sort(found.begin(), found.end(), [this](const StuckPoints& a, const StuckPoints& b) {
    return std::pair(nodes_[a.node].depth, a.node) < std::pair(nodes_[b.node].depth, b.node);
  });
  report_.has_match = !found.empty();
  for (std::size_t k = 0; k < found.size() && k < kMostPaths && report_.stuck.empty(); ++k) {
    const StuckPoints& points = found[k];
    options_.predicate = [&points](const Core& core) { return wants_to_move(core, points.atom); };
    find_path({.node = points.node, .point = points.zone.least_point(), .is_state = true, .within = &points.zone},
              report_.match);
    if (!report_.are_paths_known) continue;
    const std::vector<i64> end = point_of_core();
    for (const StuckPoints& other : found) {
      if (other.node == points.node && (other.atom == points.atom || other.zone.includes(end)) &&
          (report_.stuck.empty() || report_.stuck.back() != other.atom))
        report_.stuck.push_back(other.atom);
    }
  }
}

// The values that its clocks show.
std::vector<i64> ZoneSearch::point_of_core() const {
  std::vector<i64> point{0};
  for (u32 clock = 0; clock < locations_.clocks(); ++clock) {
    const ClockState& state = core_.time().clock_state(clock);
    point.push_back(state.value + core_.now() - state.since);
  }
  return point;
}

ZoneReport ZoneSearch::run_for_local_deadlocks() {
  notes_moves_ = true;
  search();
  if (error_.node != kNone) find_path(error_, report_.error);
  if (report_.end == ExploreEnd::Complete && report_.inexact.empty()) find_local_deadlock();
  sum_up();
  return std::move(report_);
}

ZoneReport explore_local_deadlocks(const Image& image, const ExploreOptions& options) {
  return ZoneSearch(image, options).run_for_local_deadlocks();
}

}  // namespace bip::rt
