// A monitor of what has been, beside the zone graph: its bits are a part of each location. They do not change while
// time passes, so zones are joined as ever. Whether a run violates the monitor shows on the run itself, too, without
// zones.
#include "bip/assert.hpp"
#include "runtime/explore/zone_search.hpp"

namespace bip::rt {

bool ZoneSearch::find_violated(u32 node) {
  if (monitor_ == nullptr || !monitor_->is_violated(locations_[nodes_[node].location].observed.past)) return false;
  // A run that ends in an error here is not looked at. Once it is known that guards fault, cells are cut by them.
  if (nodes_[node].is_faulty) return false;
  std::vector<i64> point = nodes_[node].zone.least_point();
  if (!enter_core(locations_[nodes_[node].location], point)) {
    locations_.cut_by_all();
    return false;
  }
  match_ = {};
  match_.node = node;
  match_.point = std::move(point);
  match_.is_state = true;
  return true;
}

namespace {

// Does the core, which takes the path, violate the monitor?
bool violates(const Image& image, const ExploreOptions& options, const TimedPath& path, const TimedMonitor& monitor) {
  Core core(image, {.progress = options.progress});
  // The path says when atoms go on.
  core.time().wait_for_resume_at();
  if (!core.initialize()) return false;
  u64 past = monitor.next(core, nullptr, 0);
  for (u64 k = 0; k < path.steps.size(); ++k) {
    const u64 choice = path.steps[k].choice;
    if (!let_time_pass(core, path, k) || choice >= core.candidate_count()) return false;
    const Candidate candidate = core.candidate(choice);
    past = monitor.next(core, &candidate, past);
    if (!core.time().take(core.position(choice))) return false;
    past = monitor.next(core, nullptr, past);
  }
  return monitor.is_violated(past);
}

}  // namespace

ZoneReport explore_monitor(const Image& image, const ExploreOptions& options, const TimedMonitor& monitor) {
  BIP_ASSERT(monitor.next && monitor.is_violated, "a monitor of nothing");
  ZoneReport report = ZoneSearch(image, options, nullptr, nullptr, &monitor).run();
  if (report.has_match && report.are_paths_known)
    report.are_paths_known = violates(image, options, report.match, monitor);
  return report;
}

}  // namespace bip::rt
