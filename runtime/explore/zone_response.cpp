// A response with a limit of time, by an observer beside the zone graph: one bit of a location says that a request
// waits, and one clock for how long the oldest one does. A response answers all requests that wait, so the oldest one
// decides. Without one the clock is forgotten. Whether a run is late shows on the run itself, too, without zones.
// Without a limit the clock shows that time passes (zone_lasso.cpp).
#include "runtime/explore/zone_search.hpp"

#include "bip/assert.hpp"

namespace bip::rt {

void ZoneSearch::observe(const Candidate* candidate, bool& is_pending, bool& is_requested) {
  BIP_ASSERT(response_ != nullptr, "an observer of nothing");
  const bool is_first = nodes_.empty();
  if (response_->response(core_, candidate)) {
    is_pending = is_requested = false;
  } else if (!is_pending && (response_->asks_once ? is_first : response_->request(core_, candidate))) {
    is_pending = is_requested = true;
  }
}

bool ZoneSearch::find_late(u32 node) {
  if (response_ == nullptr || !response_->within || !locations_[nodes_[node].location].observed.is_pending)
    return false;
  if (!nodes_[node].zone.implies(locations_.in_time().opposite())) return false;
  // A run that ends in an error here is not looked at. Once it is known that guards fault, cells are cut by them.
  if (nodes_[node].is_faulty) return false;
  const std::vector<i64> point = nodes_[node].zone.least_point();
  if (!enter_core(locations_[nodes_[node].location], point)) {
    locations_.cut_by_all();
    return false;
  }
  match_ = {node, point, false, false, {}, 0, false, true, false};
  return true;
}

namespace {

class ResponseReplay {
 public:
  ResponseReplay(const Image& image, const ExploreOptions& options, const TimedResponse& response)
      : core_(image, {.progress = options.progress}), response_(response) {}

  MissedResponse run(const TimedPath& path) {
    // The path says when atoms go on.
    core_.time().wait_for_resume_at();
    if (!core_.initialize()) return {};
    look(nullptr, 0);
    for (u64 k = 0; k < path.steps.size(); ++k) {
      const u64 choice = path.steps[k].choice;
      if (!let_time_pass(core_, path, k) || choice >= core_.candidate_count()) return {};
      if (is_late()) return found_;
      const Candidate candidate = core_.candidate(choice);
      look(&candidate, k);
      if (!core_.time().take(core_.position(choice))) return {};
      look(nullptr, k + 1);
    }
    if (!let_time_pass(core_, path, path.steps.size())) return {};
    std::vector<i64> ends;
    const bool has_ended = core_.candidate_count() == 0 && core_.time().wait_limit(ends) == core_.now();
    if (is_late()) return found_;
    found_.is_missed = is_pending_ && (has_ended || !response_.within);
    return found_;
  }

 private:
  bool is_late() {
    found_.is_missed = is_pending_ && response_.within && core_.now() - found_.requested > *response_.within;
    return found_.is_missed;
  }
  void look(const Candidate* candidate, u64 steps) {
    if (response_.response(core_, candidate)) {
      is_pending_ = false;
    } else if (!is_pending_ &&
               (response_.asks_once ? candidate == nullptr && steps == 0 : response_.request(core_, candidate))) {
      is_pending_ = true;
      found_ = {false, core_.now(), steps, candidate != nullptr};
    }
  }

  Core core_;
  const TimedResponse& response_;
  bool is_pending_ = false;
  MissedResponse found_;
};

}  // namespace

MissedResponse follow_response(const Image& image, const ExploreOptions& options, const TimedPath& path,
                               const TimedResponse& response) {
  return ResponseReplay(image, options, response).run(path);
}

ZoneReport explore_response(const Image& image, const ExploreOptions& options, const TimedResponse& response) {
  return explore_response(image, options, response, {});
}

ZoneReport explore_response(const Image& image, const ExploreOptions& options, const TimedResponse& response,
                            const std::function<void(const ListedLocation&)>& visit) {
  ZoneSearch search(image, options, nullptr, &response);
  ZoneReport report = search.run();
  if (visit) search.visit_locations(report, visit);
  if (report.has_match && report.are_paths_known) {
    const MissedResponse missed = follow_response(image, options, report.match, response);
    report.are_paths_known = missed.is_missed && missed.requested_by <= report.match_cycle.value_or(kForever);
  }
  return report;
}

}  // namespace bip::rt
