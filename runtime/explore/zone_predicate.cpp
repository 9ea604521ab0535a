// What is wrong with a node of a zone graph: points without candidate at which time stands still or may pass for ever,
// and points at which what is asked is so. Each answer is a point, from which a way is found (zone_way.cpp).
#include "runtime/explore/zone_search.hpp"

namespace bip::rt {

// rest: where the node has no candidate.
void ZoneSearch::judge(u32 node, const std::vector<Zone>& rest) {
  const Location& at = locations_[nodes_[node].location];
  bool has_deadlock = false, has_lock = false;
  const auto note = [&](Target& target, bool& has, std::vector<i64> point, bool is_far) {
    has = true;
    if (target.node == kNone) target = {node, std::move(point), false, false, 0, 0, is_far, false};
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
    if (part.is_unbounded()) note(deadlock_, has_deadlock, part.least_point(), true);
  }
  report_.deadlocks += has_deadlock ? 1 : 0;
  report_.time_locks += has_lock ? 1 : 0;
}

// Is there an instant at which what is asked is so? One point of a part answers for all of it.
bool ZoneSearch::find_broken(u32 node) {
  if (!options_.is_broken) return false;
  const Location& at = locations_[nodes_[node].location];
  // Who goes on at this instant offers nothing yet: what can be done then shows in the node that follows.
  const bool asks_offers = !options_.asked_connectors.empty() || !options_.asked_atoms.empty();
  if (nodes_[node].is_waking && asks_offers) return false;
  for (const Zone& part : cut(nodes_[node].zone, at.asked)) {
    const std::vector<i64> point = part.least_point();
    if (!enter_core(at, point) || !options_.is_broken(core_)) continue;
    broken_ = {node, point, false, false, 0, 0, false, true};
    return true;
  }
  return false;
}

}  // namespace bip::rt
