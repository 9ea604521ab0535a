// See goals.hpp.
#include "compiler/ros2/goals.hpp"

#include <algorithm>
#include <set>

namespace bip::ros2 {

Stamp stamp_now() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now);
  return {static_cast<std::int32_t>(seconds.count()),
          static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(now - seconds).count())};
}

Json to_json(const Stamp& stamp) { return {{"sec", stamp.seconds}, {"nanosec", stamp.nanoseconds}}; }
Json to_json(const GoalId& id) { return {{"uuid", id}}; }

Goal* Goals::add(std::size_t action, const GoalId& id) {
  const auto [at, is_new] = rows_.try_emplace(id);
  if (!is_new) return nullptr;
  at->second.id = id;
  at->second.action = action;
  return &at->second;
}

Goal* Goals::find(const GoalId& id) {
  const auto found = rows_.find(id);
  return found == rows_.end() ? nullptr : &found->second;
}

Goal* Goals::find_request(std::uint64_t request) {
  for (auto& [id, goal] : rows_) {
    if (goal.request == request && !is_over(goal.state)) return &goal;
  }
  return nullptr;
}

std::vector<Goal*> Goals::open() {
  std::vector<Goal*> all;
  for (auto& [id, goal] : rows_) {
    if (!is_over(goal.state)) all.push_back(&goal);
  }
  return all;
}

std::vector<Goal*> Goals::select(std::size_t action, const CancelFilter& filter, CancelCode& code) {
  const bool names_goal = filter.id != GoalId{}, names_instant = filter.stamp != Stamp{};
  std::vector<Goal*> chosen;
  code = CancelCode::None;
  for (auto& [id, goal] : rows_) {
    if (goal.action != action || is_over(goal.state)) continue;
    const bool is_meant = names_goal && id == filter.id;
    const bool is_older = names_instant && goal.accepted <= filter.stamp;
    if (is_meant || is_older || (!names_goal && !names_instant)) chosen.push_back(&goal);
  }
  if (names_goal && chosen.empty()) {
    const Goal* const meant = find(filter.id);
    code = meant == nullptr || meant->action != action || meant->is_refused ? CancelCode::UnknownGoal
                                                                            : CancelCode::Terminated;
  }
  return chosen;
}

Json Goals::status_of(std::size_t action) const {
  Json list = Json::array();
  for (const auto& [id, goal] : rows_) {
    if (goal.action != action || goal.is_refused || goal.state == GoalState::Unknown) continue;
    list.push_back({{"goal_info", {{"goal_id", to_json(id)}, {"stamp", to_json(goal.accepted)}}},
                    {"status", static_cast<int>(goal.state)}});
  }
  return {{"status_list", std::move(list)}};
}

std::vector<std::size_t> Goals::forget(Clock::time_point now) {
  std::set<std::size_t> changed;
  std::map<std::size_t, std::vector<std::pair<Clock::time_point, GoalId>>> ended;
  for (const auto& [id, goal] : rows_) {
    if (is_over(goal.state)) ended[goal.action].emplace_back(goal.ended, id);
  }
  for (auto& [action, list] : ended) {
    std::sort(list.begin(), list.end());
    const std::size_t beyond = list.size() > kMostKept ? list.size() - kMostKept : 0;
    for (std::size_t k = 0; k < list.size(); ++k) {
      if (k >= beyond && now - list[k].first < kKept) break;
      rows_.erase(list[k].second);
      changed.insert(action);
    }
  }
  return {changed.begin(), changed.end()};
}

}  // namespace bip::ros2
