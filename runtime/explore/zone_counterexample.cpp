// From a path of the zone graph to instants, and those taken by a core.
//
// Each node of the path is entered at one instant and left at another. That its clocks lie in its cell then, and that a
// step's conditions hold, are bounds on differences of such instants, for a clock is the time since it was set. The
// earliest solution is a longest path (Bellman 1958). What zones forgot is not asked for, so there is one; all the same
// the core has the last word.
#include <algorithm>

#include "bip/assert.hpp"

#include "runtime/explore/zone_search.hpp"

namespace bip::rt {

namespace {

// instants[to] >= instants[from] + ticks
struct Distance {
  u32 from, to;
  i64 ticks;
};

class Instants {
 public:
  explicit Instants(u32 clocks) : set_at_(clocks + 1, 0), set_to_(clocks + 1, 0) {}

  u32 add() { return count_++; }
  void at_least(u32 from, u32 to, i64 ticks) { distances_.push_back({from, to, ticks}); }
  void exactly(u32 from, u32 to, i64 ticks) {
    at_least(from, to, ticks);
    at_least(to, from, -ticks);
  }
  void set_clock(u32 clock, u32 when, i64 value) {
    set_at_[clock] = when;
    set_to_[clock] = value;
  }
  void demand(u32 when, const ZoneBound& bound) {
    BIP_ASSERT(when < count_ && bound.i != bound.j, "instant {} of {}", when, count_);
    const u32 i = bound.i, j = bound.j;
    if (i != 0 && j != 0) at_least(set_at_[j], set_at_[i], set_to_[i] - set_to_[j] - bound.limit);
    else if (i != 0) at_least(when, set_at_[i], set_to_[i] - bound.limit);
    else at_least(set_at_[j], when, -set_to_[j] - bound.limit);
  }
  /// By instant; empty: there is no solution.
  [[nodiscard]] std::vector<i64> earliest() const {
    std::vector<i64> at(count_, 0);
    for (u32 round = 0; round <= count_ + 1; ++round) {
      bool is_changed = false;
      for (const Distance& distance : distances_) {
        if (at[distance.to] >= at[distance.from] + distance.ticks) continue;
        at[distance.to] = at[distance.from] + distance.ticks;
        is_changed = true;
      }
      if (!is_changed) return at[0] == 0 ? at : std::vector<i64>{};
    }
    return {};
  }

 private:
  u32 count_ = 0;
  std::vector<Distance> distances_;
  std::vector<u32> set_at_;
  std::vector<i64> set_to_;
};

ZoneBound side_of(const ZoneBound& bound, const std::vector<i64>& point) {
  return point[bound.i] - point[bound.j] <= bound.limit ? bound : bound.opposite();
}

u64 number_of(const Core& core, InteractionId interaction, u32 config) {
  for (u64 k = 0; k < core.candidate_count(); ++k) {
    const Candidate candidate = core.candidate(k);
    if (candidate.interaction == interaction && candidate.config == config) return k;
  }
  return core.candidate_count();
}

bool is_dead(Core& core) {
  std::vector<i64> ends;
  return core.candidate_count() == 0 && core.time().next_change() == kForever &&
         core.time().wait_limit(ends) == kForever;
}

}  // namespace

bool let_time_pass(Core& core, i64 to) {
  std::vector<i64> ends;
  while (core.now() < to) {
    const i64 next = std::min(to, core.time().next_change());
    if (next > core.time().wait_limit(ends) || !core.time().advance(next)) return false;
  }
  return true;
}

bool let_time_pass(Core& core, const TimedPath& path, u64 number) {
  const i64 end = number == path.steps.size() ? path.end : path.steps[number].at;
  if (!core.is_timed()) return true;
  for (const u32 atom : core.time().resuming()) {
    if (!core.time().resume_at(atom, kForever)) return false;
  }
  const auto first = std::partition_point(path.resumptions.begin(), path.resumptions.end(),
                                          [&](const Resumption& r) { return r.before < number; });
  for (auto r = first; r != path.resumptions.end() && r->before == number; ++r) {
    if (!let_time_pass(core, r->at) || !core.time().resume_at(r->atom, r->at)) return false;
  }
  return let_time_pass(core, end);
}

// From the initial node to the target's, then along its cycle.
std::vector<ZoneSearch::Visit> ZoneSearch::visits_of(const Target& target) const {
  BIP_ASSERT(target.node < nodes_.size(), "node {}", target.node);
  std::vector<Visit> visits;
  for (u32 at = target.node; at != kNone; at = nodes_[at].parent) {
    const ZoneNode& node = nodes_[at];
    visits.push_back(
        {at, node.parent, node.edge, node.interaction, node.config, node.is_requested, node.is_later, &node.origin});
  }
  std::reverse(visits.begin(), visits.end());
  for (const u32 row : target.arcs) {
    const ZoneArc& arc = arcs_[row];
    BIP_ASSERT(arc.from == visits.back().node, "arc {} begins at node {}", row, arc.from);
    visits.push_back({arc.to, arc.from, arc.edge, arc.interaction, arc.config, false, arc.is_later, &arc.origin});
  }
  return visits;
}

void ZoneSearch::find_path(const Target& target, TimedPath& path) {
  path = {};
  const std::vector<Visit> visited = visits_of(target);
  Instants instants(locations_.clocks());
  report_.are_paths_known = false;
  if (!core_.initialize()) return;
  const auto note_clocks = [&](u32 when) {
    for (const u32 clock : core_.time().set_clocks())
      instants.set_clock(clock + 1, when, core_.time().clock_state(clock).value);
  };
  struct Taken {
    u32 when;
    InteractionId interaction;
    u32 config;
  };
  struct Resumed {
    u64 before;
    u32 atom, when;
  };
  std::vector<Taken> taken;
  std::vector<Resumed> resumed;
  u32 left = 0;
  for (std::size_t k = 0; k < visited.size(); ++k) {
    const Visit& visit = visited[k];
    const ZoneNode& node = nodes_[visit.node];
    const Location& at = locations_[node.location];
    const u32 entered = instants.add();
    if (k != 0) instants.exactly(left, entered, visit.edge == ZoneEdge::Time ? 1 : 0);
    if (visit.edge == ZoneEdge::Step) {
      // Once more, to see which clocks it sets.
      const Location& before = locations_[nodes_[visit.parent].location];
      for (const InteractionCondition& interaction : before.interactions) {
        if (interaction.interaction != visit.interaction) continue;
        for (const ZoneBound& bound : interaction.bounds) instants.demand(left, side_of(bound, *visit.origin));
      }
      if (!enter_core(before, *visit.origin)) return;
      const u64 choice = number_of(core_, visit.interaction, visit.config);
      if (choice == core_.candidate_count()) return;
      // At these clock values the state that it leads to may have a fault, at others of the path not.
      if (!core_.time().take(core_.position(choice)) && !core_.fault().is_of_state) return;
      taken.push_back({left, visit.interaction, visit.config});
    }
    if (visit.edge == ZoneEdge::GoOn) {
      const std::vector<u32>& before = locations_[nodes_[visit.parent].location].waits;
      for (u32 atom = 0; atom < before.size(); ++atom) {
        if (before[atom] != kNone && at.waits[atom] == kNone) resumed.push_back({taken.size(), atom, entered});
      }
    }
    if (visit.edge == ZoneEdge::Initial || visit.edge == ZoneEdge::Step) note_clocks(entered);
    if (visit.is_later) instants.demand(left, {0, locations_.in_time().i, -locations_.in_time().limit});
    if (visit.is_requested || visit.is_later) instants.set_clock(locations_.in_time().i, entered, 0);
    left = instants.add();
    instants.at_least(entered, left, 0);
    if (node.is_still) instants.exactly(entered, left, 0);
    for (const Bounds* bounds : {&at.cells, &at.invariants}) {
      for (const ZoneBound& bound : *bounds) {
        const ZoneBound side = node.zone.implies(bound) ? bound : bound.opposite();
        instants.demand(entered, side);
        instants.demand(left, side);
      }
    }
  }
  const Location& last = locations_[nodes_[target.node].location];
  std::vector<i64> point = target.point;
  // So far that no bound is ahead.
  const i64 farther = target.is_far ? 2 * *std::max_element(locations_.max().begin(), locations_.max().end()) -
                                          *std::min_element(locations_.min().begin(), locations_.min().end()) + 1
                                    : 0;
  for (u32 clock = 1; clock < point.size(); ++clock) point[clock] += farther;
  for (const ZoneBound& bound : locations_.all_bounds(last)) {
    const ZoneBound side = side_of(bound, point);
    instants.demand(left, side);
    const ZoneBound& end = target.is_bound ? side : bound;
    const bool is_reached = point[end.i] - point[end.j] == end.limit;
    // Time stops before a bound that a clock reaches from below. What it has passed may be farther behind than the
    // point says: zones forget that.
    if (is_reached && (!target.is_bound || end.i != 0)) instants.demand(left, {end.j, end.i, -end.limit});
  }
  for (u32 i = 0; target.within != nullptr && i < target.within->size(); ++i) {
    for (u32 j = 0; j < target.within->size(); ++j) {
      if (i != j && target.within->at(i, j) != Zone::kInf) instants.demand(left, {i, j, target.within->at(i, j)});
    }
  }
  if (!target.arcs.empty()) {
    const auto cycle = visited.end() - static_cast<std::ptrdiff_t>(target.arcs.size());
    report_.match_cycle = static_cast<u64>(
        std::count_if(visited.begin(), cycle, [](const Visit& visit) { return visit.edge == ZoneEdge::Step; }));
  }
  const std::vector<i64> when = instants.earliest();
  if (when.empty()) return;
  for (const Resumed& atom : resumed) path.resumptions.push_back({atom.before, atom.atom, when[atom.when]});
  path.end = when[left];
  bool is_sound = core_.initialize();
  for (const Taken& step : taken) {
    path.steps.push_back({when[step.when], 0});
    if (!is_sound || !let_time_pass(core_, path, path.steps.size() - 1)) return;
    const u64 choice = number_of(core_, step.interaction, step.config);
    if (choice == core_.candidate_count()) return;
    path.steps.back().choice = choice;
    is_sound = core_.time().take(core_.position(choice));
  }
  const bool has_passed = is_sound && let_time_pass(core_, path, path.steps.size());
  if (target.is_far) {
    is_sound = has_passed;
    const auto is_there = [&] {
      std::vector<i64> ends;
      return target.is_idle ? core_.time().next_change() == kForever && core_.time().wait_limit(ends) == kForever
                            : is_dead(core_);
    };
    while (is_sound && !is_there()) {
      if (core_.time().next_change() == kForever || !let_time_pass(core_, core_.time().next_change())) return;
    }
    path.end = core_.now();
  } else if (!has_passed) {
    if (!target.is_error || !core_.fault()) return;
  } else if (target.is_step) {
    const u64 choice = number_of(core_, target.interaction, target.config);
    if (choice == core_.candidate_count()) return;
    path.steps.push_back({core_.now(), choice});
    if (core_.time().take(core_.position(choice))) return;
  } else if (target.is_state) {
    // A response that is late is looked for along the path (follow_response).
    if (options_.predicate && !options_.predicate(core_)) return;
  } else {
    std::vector<i64> ends;
    if (core_.candidate_count() != 0 || core_.time().wait_limit(ends) != core_.now()) return;
  }
  report_.are_paths_known = true;
}

}  // namespace bip::rt
