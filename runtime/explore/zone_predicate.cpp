// What is wrong with a node of a zone graph: points without candidate at which time stands still or may pass for ever,
// and points at which the predicate holds. Each result is a point, to which a path is found (zone_counterexample.cpp).
#include "runtime/explore/zone_search.hpp"

#include "bip/assert.hpp"

namespace bip::rt {

// rest: where the node has no candidate; ends: where time has to stop because of an open bound.
void ZoneSearch::classify_dead_points(u32 node, const std::vector<Zone>& rest, const std::vector<Zone>& ends) {
  BIP_ASSERT(part_ == nullptr, "a part of a system has no deadlocks of its own");
  const Location& at = locations_[nodes_[node].location];
  bool has_deadlock = false, has_lock = false, has_end = false;
  Target lock;
  const auto note = [&](Target& target, bool& has, std::vector<i64> point, bool is_far, bool is_bound = false) {
    const bool is_first = !has;
    has = true;
    if (&target == &time_lock_ && is_first) lock = {node, point, false, false, {}, 0, is_far, false, is_bound};
    if (target.node == kNone) target = {node, std::move(point), false, false, {}, 0, is_far, false, is_bound};
  };
  const bool is_inside_now = is_inside(at, nodes_[node].zone);
  for (const Zone& part : rest) {
    if (!is_inside_now) {
      note(time_lock_, has_lock, part.least_point(), false);
      continue;
    }
    for (const ZoneBound& bound : at.invariants) {
      Zone end = part;
      if (bound.j == 0 && end.meet({0, bound.i, -bound.limit})) note(time_lock_, has_lock, end.least_point(), false);
    }
    for (const Zone& end : ends) {
      Zone common = part;
      if (common.meet(end)) note(time_lock_, has_lock, common.least_point(), false, true);
    }
    // Where an action may return, it does some time.
    if (!part.is_unbounded() || nodes_[node].is_waking) continue;
    if (at.is_final) has_end = true;
    else note(deadlock_, has_deadlock, part.least_point(), true);
  }
  // No response comes after the end of a run.
  if (has_lock && at.observed.is_pending) {
    match_ = lock;
    report_.is_match_end = true;
  }
  report_.deadlocks += has_deadlock ? 1 : 0;
  report_.finals += has_end ? 1 : 0;
  report_.time_locks += has_lock ? 1 : 0;
}

// Finds an instant at which the predicate holds. One point of a part decides for all of it.
bool ZoneSearch::find_match(u32 node) {
  if (!options_.predicate) return false;
  const Location& at = locations_[nodes_[node].location];
  // Who goes on at this instant at the latest offers nothing yet: what can be done then shows in the node that follows.
  const bool asks_offers = !options_.predicate_connectors.empty() || !options_.predicate_atoms.empty();
  std::vector<Zone> parts = cut(nodes_[node].zone, at.asked);
  if (nodes_[node].is_waking && asks_offers) parts = without_last(node, std::move(parts));
  for (const Zone& part : parts) {
    const std::vector<i64> point = part.least_point();
    if (!enter_core(at, point) || !options_.predicate(core_)) continue;
    match_ = {node, point, false, false, {}, 0, false, true, false};
    return true;
  }
  return false;
}

}  // namespace bip::rt
