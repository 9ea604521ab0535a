// Actions of ROS 2 over topics of ROS 1: what `ros2::Bridge` writes and reads as services and topics of an action
// becomes the five topics of actionlib (goal, cancel, status, feedback, result). So both ROS have one bridge.
//
// actionlib pushes a result where ROS 2 lets a client fetch it: this end asks for the result of each goal itself.
// Status is published five times a second, as actionlib's servers do, because its clients take a server for there by
// that.
#pragma once
#include <array>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "compiler/ros1/topic_bus.hpp"
#include "compiler/ros1/types.hpp"
#include "compiler/ros2/bus.hpp"
#include "compiler/ros2/goals.hpp"

namespace bip::ros1 {

class ActionBus final : public ros2::Bus {
 public:
  /// `interfaces` lives longer.
  ActionBus(const ros2::Interfaces& interfaces, std::unique_ptr<TopicBus> topics);
  ~ActionBus() override;

  [[nodiscard]] Result<std::size_t> add_reader(const ros2::EndpointPlan& plan) override;
  [[nodiscard]] Result<std::size_t> add_writer(const ros2::EndpointPlan& plan) override;
  [[nodiscard]] int descriptor() const override { return waits_; }
  void reset() override;
  [[nodiscard]] std::vector<ros2::Sample> take(std::size_t reader) override;
  [[nodiscard]] std::string write(std::size_t writer, const Bytes& bytes) override;
  /// Topics of ROS 1 reach all that subscribe, and no reply waits for its client.
  [[nodiscard]] bool has_reader(std::size_t, const ros2::PeerId&) override { return true; }
  /// Any client: ROS 1 does not say which node has gone.
  [[nodiscard]] bool has_writer(std::size_t reader, const ros2::PeerId& peer) override;
  [[nodiscard]] std::size_t readers_of(std::size_t writer) override;

 private:
  enum class Part : std::uint8_t { SendGoal, CancelGoal, GetResult, Feedback, Status, Poster };
  struct End {
    Part part = Part::Poster;
    std::size_t action = 0;     // of actions_
    std::size_t publisher = 0;  // of a poster
    std::string message{};      // of a poster
  };
  struct Action {
    std::string type;  // "dala_msgs/action/NDDGoTo"
    std::string name;  // "dala_msgs/NDDGoTo"
    std::size_t goal = 0, cancel = 0, result = 0, feedback = 0, status = 0;
    std::deque<ros2::Sample> wanted_results;
    ros2::Json statuses = ros2::Json::array();
  };
  /// A client's goal under the id that the bridge knows.
  struct KnownGoal {
    std::size_t action = 0;
    std::string id;
    ros2::Stamp stamp{};
    bool is_refused = false, has_result = false;
  };

  [[nodiscard]] Result<std::size_t> action_of(const ros2::EndpointPlan& plan);
  [[nodiscard]] std::vector<ros2::Sample> take_goals(std::size_t action);
  [[nodiscard]] std::vector<ros2::Sample> take_cancels(std::size_t action);
  void answer_goal(std::size_t action, const ros2::Json& reply, std::int64_t number);
  void publish_result(std::size_t action, const ros2::Json& reply, std::int64_t number);
  void publish_feedback(std::size_t action, const ros2::Json& feedback);
  void keep_status(std::size_t action, const ros2::Json& list);
  void publish_status(const Action& action);
  void publish(std::size_t publisher, const std::string& type, ros2::Json value);
  [[nodiscard]] ros2::Json status_row(const ros2::GoalId& id, std::uint8_t status, const std::string& text) const;
  void wake() const;

  Types types_;
  const ros2::Messages& messages_;  // of ROS 2
  std::unique_ptr<TopicBus> topics_;
  int waits_, event_, timer_;
  std::vector<Action> actions_;
  std::map<std::string, std::size_t> action_rows_;  // by name of the action, with its namespace
  std::vector<End> readers_, writers_;
  std::map<ros2::GoalId, KnownGoal> goals_;
  std::map<std::int64_t, ros2::GoalId> asked_;  // numbers of requests to the bridge
  std::int64_t next_number_ = 1;
  std::uint64_t next_id_ = 1;
  std::string wrong_;  // of the last write
};

}  // namespace bip::ros1
