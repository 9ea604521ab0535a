// What a functional level is in ROS 2: an action for each service, a topic for each poster, and the messages that they
// are made of. Read from descriptions of modules; a running `bipc serve` is not asked.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/genom/constraints.hpp"
#include "compiler/genom/module.hpp"
#include "compiler/ros2/messages.hpp"

namespace bip::ros2 {

/// A service of a module, as an action.
struct Action {
  std::string service;  // "NDD.GoTo", as `bipc serve` has it
  std::string name;     // "NDD/GoTo"
  std::string type;     // "dala_msgs/action/NDDGoTo"
  /// Members of the goal that are written in parentheses behind the service: rules speak of them.
  std::vector<std::string> values;
  /// Of these, parameters that codels of genom3 get: they are in the input as well.
  std::vector<std::string> shared_values = {};
  bool takes_text = false;  // the input is the member `input`, a text; else all other members are the input, an object
};
/// A poster, or a port out, as a topic.
struct Topic {
  std::string poster;    // "NDD.Speed"
  std::string name;      // "NDD/Speed"
  std::string type;      // "dala_msgs/msg/NDDSpeed"
  bool is_bare = false;  // its value is no object: the member `data`
};
struct Interfaces {
  std::string package;
  Messages messages;
  std::vector<std::string> own;  // messages of the package, those that others are made of first
  std::vector<Action> actions;
  std::vector<Topic> topics;
};

/// Members of each action's result and feedback: the report, and details as JSON.
inline constexpr const char* kReport = "report";
inline constexpr const char* kDetail = "detail";
inline constexpr const char* kInput = "input";
inline constexpr const char* kData = "data";

/// Is it a name that ROS 2 gives a package?
[[nodiscard]] bool is_package_name(const std::string& name);
/// The default name of the package: "demo_msgs" for module Demo.
[[nodiscard]] std::string package_for(const std::string& name);

/// Of `modules` those named in `only` (all if it is empty). What has no counterpart in ROS 2 is left out, with a
/// warning.
[[nodiscard]] Interfaces make_interfaces(const std::vector<genom::Module>& modules,
                                         const genom::Constraints& constraints, const std::string& package,
                                         const std::vector<std::string>& only, Diagnostics& diags);

/// Name and text of each file of the package: package.xml, CMakeLists.txt, msg/*.msg, action/*.action.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> package_files(const Interfaces& interfaces);

}  // namespace bip::ros2
