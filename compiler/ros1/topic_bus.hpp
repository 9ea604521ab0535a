// What the bridge needs of ROS 1: subscribers and publishers of serialized messages. The one implementation is in
// compiler/roscpp, a plug-in; nothing here knows the client library.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/ros2/messages.hpp"

namespace bip::ros1 {

using ros2::Bytes;

struct TopicPlan {
  std::string topic;       // "/NDD/GoTo/goal"
  std::string type;        // "dala_msgs/NDDGoToActionGoal"
  std::string md5;         // of the type: both ends must have the same
  std::string definition;  // the type and those that it is made of, as text
  std::uint32_t depth = 10;
  bool is_latched = false;  // late subscribers get the last message
};

struct TopicMessage {
  Bytes bytes;
  std::string sender;  // name of the node
};

class TopicBus {
 public:
  TopicBus() = default;
  TopicBus(const TopicBus&) = delete;
  TopicBus& operator=(const TopicBus&) = delete;
  virtual ~TopicBus() = default;

  /// Subscribers and publishers are numbers from 0 on.
  [[nodiscard]] virtual Result<std::size_t> subscribe(const TopicPlan& plan) = 0;
  [[nodiscard]] virtual Result<std::size_t> advertise(const TopicPlan& plan) = 0;
  /// A file descriptor that can be read when messages have come; reset() before taking.
  [[nodiscard]] virtual int descriptor() const = 0;
  virtual void reset() = 0;
  [[nodiscard]] virtual std::vector<TopicMessage> take(std::size_t subscriber) = 0;
  virtual void publish(std::size_t publisher, const Bytes& bytes) = 0;
  [[nodiscard]] virtual std::size_t publishers_of(std::size_t subscriber) = 0;
  [[nodiscard]] virtual std::size_t subscribers_of(std::size_t publisher) = 0;
};

class TopicBusFactory {
 public:
  TopicBusFactory() = default;
  TopicBusFactory(const TopicBusFactory&) = delete;
  TopicBusFactory& operator=(const TopicBusFactory&) = delete;
  virtual ~TopicBusFactory() = default;
  /// A node of this name, at the master of $ROS_MASTER_URI. One in a process.
  [[nodiscard]] virtual Result<std::unique_ptr<TopicBus>> open(const std::string& node) const = 0;
};

}  // namespace bip::ros1
