// Message types of ROS 1: those of a functional level (compiler/ros2/interfaces) under the names of ROS 1, with those
// that actionlib makes of an action; their definitions as text, and the MD5 by which both ends of a topic compare them.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "compiler/ros2/interfaces.hpp"
#include "compiler/ros2/messages.hpp"

namespace bip::ros1 {

/// "dala_msgs/action/NDDGoTo" and "dala_msgs/msg/Pose": "dala_msgs/NDDGoTo" and "dala_msgs/Pose".
[[nodiscard]] std::string short_name(const std::string& name);

class Types {
 public:
  explicit Types(const ros2::Interfaces& interfaces);
  [[nodiscard]] const ros2::Messages& messages() const { return messages_; }
  /// 32 hexadecimal digits. Source: the documentation of ROS 1, "Technical Overview", message serialization.
  [[nodiscard]] std::string md5_of(const std::string& name) const;
  /// The type's text, then that of each type that it is made of, under a line that names it.
  [[nodiscard]] std::string definition_of(const std::string& name) const;

 private:
  void add_action(const std::string& name, const ros2::Messages& from, const std::string& type);
  [[nodiscard]] std::string text_of(const std::string& name) const;
  ros2::Messages messages_;
};

/// Name and text of each file of the catkin package: package.xml, CMakeLists.txt, msg/*.msg, action/*.action.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> package_files(const ros2::Interfaces& interfaces);

}  // namespace bip::ros1
