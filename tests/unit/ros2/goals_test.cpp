// The table of goals: which goals a cancellation selects, the status, what is removed.
#include "compiler/ros2/goals.hpp"

#include <catch2/catch.hpp>

namespace bip::ros2 {
namespace {

GoalId id_of(std::uint8_t number) { return {number}; }

Goal& running(Goals& goals, std::uint8_t number, std::int32_t accepted) {
  Goal* const goal = goals.add(0, id_of(number));
  REQUIRE(goal != nullptr);
  goal->state = GoalState::Executing;
  goal->accepted = {accepted, 0};
  return *goal;
}

std::vector<std::uint8_t> chosen(Goals& goals, const CancelFilter& filter, CancelCode& code) {
  std::vector<std::uint8_t> numbers;
  for (const Goal* goal : goals.select(0, filter, code)) numbers.push_back(goal->id[0]);
  return numbers;
}

// The four forms of action_msgs/srv/CancelGoal.
TEST_CASE("which goals a cancellation means") {
  Goals goals;
  running(goals, 1, 10);
  running(goals, 2, 20);
  running(goals, 3, 30);
  REQUIRE(goals.add(1, id_of(4)) != nullptr);  // of another action
  CancelCode code{};
  CHECK(chosen(goals, {}, code) == std::vector<std::uint8_t>{1, 2, 3});
  CHECK(chosen(goals, {{}, {20, 0}}, code) == std::vector<std::uint8_t>{1, 2});
  CHECK(chosen(goals, {id_of(3), {}}, code) == std::vector<std::uint8_t>{3});
  CHECK(chosen(goals, {id_of(3), {10, 0}}, code) == std::vector<std::uint8_t>{1, 3});
  CHECK(code == CancelCode::None);
}

TEST_CASE("why a goal is not cancelled") {
  Goals goals;
  running(goals, 1, 10).state = GoalState::Succeeded;
  Goal& refused = running(goals, 2, 10);
  refused.state = GoalState::Aborted;
  refused.is_refused = true;
  CancelCode code{};
  CHECK(chosen(goals, {id_of(1), {}}, code).empty());
  CHECK(code == CancelCode::Terminated);
  CHECK(chosen(goals, {id_of(2), {}}, code).empty());
  CHECK(code == CancelCode::UnknownGoal);
  CHECK(chosen(goals, {id_of(9), {}}, code).empty());
  CHECK(code == CancelCode::UnknownGoal);
  CHECK(chosen(goals, {}, code).empty());
  CHECK(code == CancelCode::None);
}

TEST_CASE("the status has goals that were accepted, and no others") {
  Goals goals;
  running(goals, 1, 10);
  REQUIRE(goals.add(0, id_of(2)) != nullptr);  // not decided yet
  Goal& refused = running(goals, 3, 10);
  refused.state = GoalState::Aborted;
  refused.is_refused = true;
  const Json list = goals.status_of(0)["status_list"];
  REQUIRE(list.size() == 1);
  CHECK(list[0]["goal_info"]["goal_id"]["uuid"][0] == 1);
  CHECK(list[0]["status"] == 2);
  CHECK(goals.add(0, id_of(1)) == nullptr);
}

TEST_CASE("what ended is kept for a while, and not without bound") {
  Goals goals;
  const Clock::time_point now = Clock::now();
  for (std::size_t k = 0; k < Goals::kMostKept + 5; ++k) {
    Goal* const goal = goals.add(0, {static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(k >> 8), 1});
    REQUIRE(goal != nullptr);
    goal->state = GoalState::Succeeded;
    goal->ended = now + std::chrono::milliseconds(k);
  }
  running(goals, 0, 10);
  CHECK(goals.forget(now) == std::vector<std::size_t>{0});
  CHECK(goals.status_of(0)["status_list"].size() == Goals::kMostKept + 1);
  CHECK(goals.forget(now).empty());
  CHECK(goals.find({0, 0, 1}) == nullptr);
  CHECK(goals.forget(now + Goals::kKept + std::chrono::seconds(1)) == std::vector<std::size_t>{0});
  CHECK(goals.open().size() == 1);
  CHECK(goals.status_of(0)["status_list"].size() == 1);
}

}  // namespace
}  // namespace bip::ros2
