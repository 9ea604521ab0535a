// See types.hpp.
#include "compiler/ros1/types.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/uuid/detail/md5.hpp>

#include "compiler/ros2/message_text.hpp"

namespace bip::ros1 {
namespace {

using ros2::Dialect;
using ros2::Field;
using ros2::Kind;
using ros2::Message;
using ros2::Messages;
using ros2::Shape;

// A built-in type of ROS 1; here a message of two numbers.
constexpr const char* kTime = "time";

constexpr const char* kGoalStatus = "actionlib_msgs/GoalStatus";
constexpr const char* kGoalStatusConstants =
    "uint8 PENDING=0\nuint8 ACTIVE=1\nuint8 PREEMPTED=2\nuint8 SUCCEEDED=3\nuint8 ABORTED=4\nuint8 REJECTED=5\n"
    "uint8 PREEMPTING=6\nuint8 RECALLING=7\nuint8 RECALLED=8\nuint8 LOST=9\n";

std::string md5(const std::string& text) {
  boost::uuids::detail::md5 hash;
  hash.process_bytes(text.data(), text.size());
  boost::uuids::detail::md5::digest_type digest{};
  hash.get_digest(digest);
  // Words of 32 bits, in later versions of Boost bytes.
  std::string out;
  for (const auto part : digest) out += fmt::format("{:0{}x}", part, 2 * sizeof part);
  return out;
}

std::vector<Field> renamed(std::vector<Field> fields) {
  for (Field& field : fields) {
    if (field.kind == Kind::Message) field.message = short_name(field.message);
  }
  return fields;
}

Field part(const char* name, const std::string& message, Shape shape = Shape::One) {
  return {.name = name, .kind = Kind::Message, .message = message, .shape = shape};
}
Field text(const char* name) { return {.name = name, .kind = Kind::String}; }

}  // namespace

std::string short_name(const std::string& name) {
  const std::size_t first = name.find('/'), last = name.rfind('/');
  return first == last ? name : name.substr(0, first) + name.substr(last);
}

Types::Types(const ros2::Interfaces& interfaces) {
  messages_.add({kTime, {{.name = "secs", .kind = Kind::UInt32}, {.name = "nsecs", .kind = Kind::UInt32}}});
  messages_.add({"std_msgs/Header", {{.name = "seq", .kind = Kind::UInt32}, part("stamp", kTime), text("frame_id")}});
  messages_.add({"actionlib_msgs/GoalID", {part("stamp", kTime), text("id")}});
  Message status{kGoalStatus,
                 {part("goal_id", "actionlib_msgs/GoalID"), {.name = "status", .kind = Kind::UInt8}, text("text")}};
  messages_.add(std::move(status));
  messages_.add({"actionlib_msgs/GoalStatusArray",
                 {part("header", "std_msgs/Header"), part("status_list", kGoalStatus, Shape::Sequence)}});
  for (const std::string& name : interfaces.own) {
    messages_.add({short_name(name), renamed(interfaces.messages.at(name).fields)});
  }
  for (const ros2::Action& action : interfaces.actions)
    add_action(short_name(action.type), interfaces.messages, action.type);
}

void Types::add_action(const std::string& name, const Messages& from, const std::string& type) {
  for (const char* const which : {"Goal", "Result", "Feedback"})
    messages_.add({name + which, renamed(from.at(type + "_" + which).fields)});
  messages_.add(
      {name + "ActionGoal",
       {part("header", "std_msgs/Header"), part("goal_id", "actionlib_msgs/GoalID"), part("goal", name + "Goal")}});
  messages_.add({name + "ActionResult",
                 {part("header", "std_msgs/Header"), part("status", kGoalStatus), part("result", name + "Result")}});
  messages_.add(
      {name + "ActionFeedback",
       {part("header", "std_msgs/Header"), part("status", kGoalStatus), part("feedback", name + "Feedback")}});
}

// A constant is its own line, a field of another message has that message's MD5 in the place of its type.
std::string Types::md5_of(const std::string& name) const {
  const std::vector<Field>& fields = messages_.at(name).fields;
  std::string lines = name == kGoalStatus ? kGoalStatusConstants : ros2::constants_text(fields);
  for (const Field& field : fields) {
    const bool is_built_in = field.kind != Kind::Message || field.message == kTime;
    lines +=
        (is_built_in ? ros2::type_text(field, "", Dialect::Ros1) : md5_of(field.message)) + " " + field.name + "\n";
  }
  if (!lines.empty()) lines.pop_back();
  return md5(lines);
}

std::string Types::text_of(const std::string& name) const {
  return (name == kGoalStatus ? kGoalStatusConstants : "") +
         ros2::fields_text(messages_.at(name).fields, "", Dialect::Ros1);
}

std::string Types::definition_of(const std::string& name) const {
  std::vector<std::string> names{name};
  for (std::size_t k = 0; k < names.size(); ++k) {
    for (const Field& field : messages_.at(names[k]).fields) {
      const bool is_new = std::find(names.begin(), names.end(), field.message) == names.end();
      if (field.kind == Kind::Message && field.message != kTime && is_new) names.push_back(field.message);
    }
  }
  std::string out = text_of(name);
  for (std::size_t k = 1; k < names.size(); ++k)
    out += fmt::format("{:=<80}\nMSG: {}\n{}", "", names[k], text_of(names[k]));
  return out;
}

std::vector<std::pair<std::string, std::string>> package_files(const ros2::Interfaces& interfaces) {
  std::vector<std::pair<std::string, std::string>> files;
  const std::string& package = interfaces.package;
  std::string messages, actions;
  const auto text = [&](const std::string& name) {
    return ros2::fields_text(renamed(interfaces.messages.at(name).fields), package, Dialect::Ros1);
  };
  for (const std::string& name : interfaces.own) {
    const std::string file = name.substr(name.rfind('/') + 1) + ".msg";
    messages += " " + file;
    files.emplace_back("msg/" + file, text(name));
  }
  for (const ros2::Action& action : interfaces.actions) {
    const std::string file = action.type.substr(action.type.rfind('/') + 1) + ".action";
    actions += " " + file;
    files.emplace_back("action/" + file,
                       fmt::format("# {}\n{}---\n{}---\n{}", action.service, text(action.type + "_Goal"),
                                   text(action.type + "_Result"), text(action.type + "_Feedback")));
  }
  files.emplace_back("CMakeLists.txt",
                     fmt::format("cmake_minimum_required(VERSION 3.0.2)\nproject({})\n"
                                 "find_package(catkin REQUIRED COMPONENTS actionlib_msgs message_generation std_msgs)\n"
                                 "{}{}generate_messages(DEPENDENCIES actionlib_msgs std_msgs)\n"
                                 "catkin_package(CATKIN_DEPENDS actionlib_msgs message_runtime std_msgs)\n",
                                 package, messages.empty() ? "" : fmt::format("add_message_files(FILES{})\n", messages),
                                 actions.empty() ? "" : fmt::format("add_action_files(FILES{})\n", actions)));
  files.emplace_back(
      "package.xml",
      fmt::format("<?xml version=\"1.0\"?>\n<package format=\"2\">\n  <name>{}</name>\n  <version>0.0.0</version>\n"
                  "  <description>Services and posters of robot modules, written by bipc ros1</description>\n"
                  "  <maintainer email=\"nobody@localhost.localdomain\">nobody</maintainer>\n"
                  "  <license>unknown</license>\n"
                  "  <buildtool_depend>catkin</buildtool_depend>\n"
                  "  <build_depend>message_generation</build_depend>\n"
                  "  <depend>actionlib_msgs</depend>\n  <depend>std_msgs</depend>\n"
                  "  <exec_depend>message_runtime</exec_depend>\n</package>\n",
                  package));
  return files;
}

}  // namespace bip::ros1
