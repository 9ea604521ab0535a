// Goals of ROS 2 actions, from what a client asks for to the result that it fetches: the table of an action server,
// without a network. States are those of action_msgs/msg/GoalStatus.
#pragma once
#include <array>
#include <chrono>
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "compiler/ros2/bus.hpp"
#include "compiler/ros2/messages.hpp"

namespace bip::ros2 {

using GoalId = std::array<std::uint8_t, 16>;
using Clock = std::chrono::steady_clock;

enum class GoalState : std::int8_t {
  Unknown = 0,  // it is not decided yet
  Accepted = 1,
  Executing = 2,
  Canceling = 3,
  Succeeded = 4,
  Canceled = 5,
  Aborted = 6
};
[[nodiscard]] constexpr bool is_over(GoalState state) { return state >= GoalState::Succeeded; }

/// Instants of ROS: seconds and nanoseconds since 1970.
struct Stamp {
  std::int32_t seconds = 0;
  std::uint32_t nanoseconds = 0;
  auto operator<=>(const Stamp&) const = default;
};
[[nodiscard]] Stamp stamp_now();
[[nodiscard]] Json to_json(const Stamp& stamp);
[[nodiscard]] Json to_json(const GoalId& id);

/// Who waits for the reply of a service.
struct Asker {
  RequestHeader header;
  std::optional<PeerId> peer;
};

struct Goal {
  GoalId id{};
  std::size_t action = 0;
  std::uint64_t request = 0;  // number of `bipc serve`; 0: not known yet
  GoalState state = GoalState::Unknown;
  bool is_refused = false;  // then it is over, and no part of the status
  bool is_cancel_asked = false;
  Stamp accepted;               // until it is accepted: when it came
  std::optional<Asker> asker;   // waits for acceptance
  std::vector<Asker> awaiting;  // wait for the result
  Json result = Json::object();
  Clock::time_point ended;
};

/// A client's CancelGoal_Request: one goal, all, or those until an instant.
struct CancelFilter {
  GoalId id{};
  Stamp stamp;
};
/// Return codes of action_msgs/srv/CancelGoal.
enum class CancelCode : std::int8_t { None = 0, Rejected = 1, UnknownGoal = 2, Terminated = 3 };

class Goals {
 public:
  static constexpr std::chrono::seconds kKept{60};  // a result that no client fetched
  static constexpr std::size_t kMostKept = 200;     // of one action

  /// Null: there is one of this id.
  [[nodiscard]] Goal* add(std::size_t action, const GoalId& id);
  [[nodiscard]] Goal* find(const GoalId& id);
  [[nodiscard]] Goal* find_request(std::uint64_t request);
  /// Goals of an action that are not over and that the filter means; the code is for when there are none.
  [[nodiscard]] std::vector<Goal*> select(std::size_t action, const CancelFilter& filter, CancelCode& code);
  /// Those that are not over.
  [[nodiscard]] std::vector<Goal*> open();
  /// GoalStatusArray of an action.
  [[nodiscard]] Json status_of(std::size_t action) const;
  /// Removes what ended long ago. Returns the actions whose status is another one now.
  [[nodiscard]] std::vector<std::size_t> forget(Clock::time_point now);

 private:
  std::map<GoalId, Goal> rows_;
};

}  // namespace bip::ros2
