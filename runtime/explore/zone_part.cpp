// A part of a system (zones.hpp, PartQuestion): which locations the whole cannot have, and where time stands still
// though no atom of the part can go on. Steps in which others take part count for what they lead to, not as a way out.
#include <algorithm>

#include "bip/assert.hpp"

#include "runtime/explore/zone_search.hpp"

namespace bip::rt {

// The core is at the location when it is new: `measure` has just been there, or goes there anew.
bool ZoneSearch::is_impossible(u32 row) {
  using Feasibility = Location::Feasibility;
  BIP_ASSERT(part_ != nullptr && row < locations_.size(), "location {}", row);
  Location& at = locations_[row];
  if (at.in_whole == Feasibility::NotDecided) {
    const std::vector<i64> clocks(locations_.clocks() + 1, 0);
    const bool is_none = part_->is_impossible && enter_core(at, clocks) && part_->is_impossible(core_);
    at.in_whole = is_none ? Feasibility::Impossible : Feasibility::Possible;
    impossible_ += is_none ? 1 : 0;
  }
  return at.in_whole == Feasibility::Impossible;
}

bool ZoneSearch::is_asked_for(u32 node) {
  return part_->asks_places && enter_core(locations_[nodes_[node].location], nodes_[node].zone.least_point()) &&
         part_->is_asked(core_);
}

// rest: where no step of the part alone can be taken.
bool ZoneSearch::is_held_up(const Location& at, const std::vector<Zone>& rest) {
  if (rest.empty() || part_->asks_places) return false;
  if (part_->is_asked && enter_core(at, rest[0].least_point()) && !part_->is_asked(core_)) return false;
  if (!at.may_go_on) return true;
  const AtomTime* time = image_.atom_types[image_.atoms[part_->atom].type].time;
  const u32 first = core_.time().first_clock(part_->atom) + 1, end = first + (time == nullptr ? 0 : time->clocks.size);
  for (const ZoneBound& bound : at.invariants) {
    const u32 clock = std::max(bound.i, bound.j);
    if (clock < first || clock >= end) continue;
    for (const Zone& part : rest) {
      if (!part.implies(bound)) return true;
      Zone last = part;
      if (bound.j == 0 && last.meet({0, bound.i, -bound.limit})) return true;
    }
  }
  return false;
}

PartReport ZoneSearch::run_part() {
  search();
  PartReport report;
  report.inexact = report_.inexact;
  // A fault at the very beginning says nothing of what comes after it in the whole.
  report.is_complete = report_.inexact.empty() && report_.end == ExploreEnd::Complete && locations_.size() != 0;
  report.is_open = open_ != kNone;
  if (report.is_open) report.open = locations_[open_].state;
  report.zones = report_.zones;
  report.locations = locations_.size();
  report.impossible = impossible_;
  if (part_->visit && report.is_complete && !report.is_open)
    visit_locations(report_, [&](const ListedLocation& location) { part_->visit(image_, location); });
  return report;
}

PartReport explore_part(const Image& image, const ExploreOptions& options, const PartQuestion& question) {
  return ZoneSearch(image, options, &question).run_part();
}

}  // namespace bip::rt
