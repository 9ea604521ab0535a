// See action_bus.hpp. Source of the topics and of their states: the description of actionlib's protocol.
#include "compiler/ros1/action_bus.hpp"

#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <set>
#include <utility>

#include "bip/assert.hpp"
#include "compiler/ros2/sha256.hpp"

namespace bip::ros1 {
namespace {

using ros2::EndpointPlan;
using ros2::GoalId;
using ros2::GoalState;
using ros2::Json;
using ros2::PeerId;
using ros2::RequestHeader;
using ros2::Sample;
using ros2::Stamp;

constexpr long kStatusEvery = 200'000'000;  // ns
constexpr std::size_t kMostWaiting = 100;   // messages of a topic

/// Numbers of actionlib_msgs/GoalStatus.
enum class GoalStatus : std::uint8_t { Pending, Active, Preempted, Succeeded, Aborted, Rejected, Preempting };

GoalStatus status_of(GoalState state) {
  switch (state) {
    case GoalState::Unknown:
    case GoalState::Accepted: return GoalStatus::Pending;
    case GoalState::Executing: return GoalStatus::Active;
    case GoalState::Canceling: return GoalStatus::Preempting;
    case GoalState::Succeeded: return GoalStatus::Succeeded;
    case GoalState::Canceled: return GoalStatus::Preempted;
    case GoalState::Aborted: return GoalStatus::Aborted;
  }
  BIP_UNREACHABLE("not a state of a goal");
}
std::uint8_t number_of(GoalStatus status) { return static_cast<std::uint8_t>(status); }
GoalState state_of(const Json& number) { return static_cast<GoalState>(number.get<int>()); }

GoalId bytes_of(const std::string& text) {
  const std::string digits = ros2::sha256(text);
  GoalId id{};
  for (std::size_t k = 0; k < id.size(); ++k)
    id[k] = static_cast<std::uint8_t>(std::stoi(digits.substr(2 * k, 2), nullptr, 16));
  return id;
}
GoalId id_of(const Json& goal_id) {
  GoalId id{};
  for (std::size_t k = 0; k < id.size(); ++k) id[k] = goal_id["uuid"][k].get<std::uint8_t>();
  return id;
}
std::string text_of(const GoalId& id) {
  std::string text;
  for (const std::uint8_t byte : id) text += fmt::format("{:02x}", byte);
  return text;
}
Stamp stamp_of(const Json& time) {
  return {static_cast<std::int32_t>(time["secs"].get<std::uint32_t>()), time["nsecs"].get<std::uint32_t>()};
}
Json to_time(const Stamp& stamp) {
  return {{"secs", static_cast<std::uint32_t>(stamp.seconds)}, {"nsecs", stamp.nanoseconds}};
}
void watch(int waits, int descriptor) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = descriptor;
  BIP_ENSURE(::epoll_ctl(waits, EPOLL_CTL_ADD, descriptor, &event) == 0);
}
void drain(int descriptor) {
  std::uint64_t ignored = 0;
  (void)!::read(descriptor, &ignored, sizeof ignored);
}

}  // namespace

ActionBus::ActionBus(const ros2::Interfaces& interfaces, std::unique_ptr<TopicBus> topics)
    : types_(interfaces),
      messages_(interfaces.messages),
      topics_(std::move(topics)),
      waits_(::epoll_create1(EPOLL_CLOEXEC)),
      event_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)) {
  BIP_ENSURE(waits_ >= 0 && event_ >= 0 && timer_ >= 0);
  const itimerspec period{{0, kStatusEvery}, {0, kStatusEvery}};
  BIP_ENSURE(::timerfd_settime(timer_, 0, &period, nullptr) == 0);
  for (const int descriptor : {topics_->descriptor(), event_, timer_}) watch(waits_, descriptor);
}

ActionBus::~ActionBus() {
  for (const int descriptor : {waits_, event_, timer_}) (void)::close(descriptor);
}

// The five topics are made with the first end of an action that the bridge asks for.
Result<std::size_t> ActionBus::action_of(const EndpointPlan& plan) {
  const std::string name = plan.name.substr(0, plan.name.find("/_action/"));
  if (const auto found = action_rows_.find(name); found != action_rows_.end()) return found->second;
  const std::string suffix = "_SendGoal_Request";
  BIP_ASSERT(plan.message.ends_with(suffix), "the first end of {} is {}", name, plan.message);
  Action action;
  action.type = plan.message.substr(0, plan.message.size() - suffix.size());
  action.name = short_name(action.type);
  std::string wrong;
  enum class TopicEnd : std::uint8_t { Subscriber, Publisher };
  const auto open = [&](TopicEnd end, const char* topic, const std::string& type) -> std::size_t {
    if (!wrong.empty()) return 0;
    const TopicPlan topic_plan{.topic = "/" + name + "/" + topic,
                               .type = type,
                               .md5 = types_.md5_of(type),
                               .definition = types_.definition_of(type),
                               .depth = kMostWaiting};
    const Result<std::size_t> made =
        end == TopicEnd::Subscriber ? topics_->subscribe(topic_plan) : topics_->advertise(topic_plan);
    if (made) return *made;
    wrong = made.error();
    return 0;
  };
  action.goal = open(TopicEnd::Subscriber, "goal", action.name + "ActionGoal");
  action.cancel = open(TopicEnd::Subscriber, "cancel", "actionlib_msgs/GoalID");
  action.status = open(TopicEnd::Publisher, "status", "actionlib_msgs/GoalStatusArray");
  action.feedback = open(TopicEnd::Publisher, "feedback", action.name + "ActionFeedback");
  action.result = open(TopicEnd::Publisher, "result", action.name + "ActionResult");
  if (!wrong.empty()) return Failure{wrong};
  actions_.push_back(std::move(action));
  action_rows_.emplace(name, actions_.size() - 1);
  return actions_.size() - 1;
}

Result<std::size_t> ActionBus::add_reader(const EndpointPlan& plan) {
  const Result<std::size_t> action = action_of(plan);
  if (!action) return Failure{action.error()};
  const Part part = plan.name.ends_with("/send_goal")     ? Part::SendGoal
                    : plan.name.ends_with("/cancel_goal") ? Part::CancelGoal
                                                          : Part::GetResult;
  readers_.push_back({.part = part, .action = *action});
  return readers_.size() - 1;
}

Result<std::size_t> ActionBus::add_writer(const EndpointPlan& plan) {
  if (plan.name.find("/_action/") == std::string::npos) {
    const std::string type = short_name(plan.message);
    const Result<std::size_t> publisher = topics_->advertise({.topic = "/" + plan.name,
                                                              .type = type,
                                                              .md5 = types_.md5_of(type),
                                                              .definition = types_.definition_of(type),
                                                              .depth = 1,
                                                              .is_latched = true});
    if (!publisher) return Failure{publisher.error()};
    writers_.push_back({.part = Part::Poster, .publisher = *publisher, .message = plan.message});
    return writers_.size() - 1;
  }
  const Result<std::size_t> action = action_of(plan);
  if (!action) return Failure{action.error()};
  const auto is = [&](const char* end) { return plan.name.ends_with(end); };
  const Part part = is("/send_goal")     ? Part::SendGoal
                    : is("/cancel_goal") ? Part::CancelGoal
                    : is("/get_result")  ? Part::GetResult
                    : is("/feedback")    ? Part::Feedback
                                         : Part::Status;
  writers_.push_back({.part = part, .action = *action});
  return writers_.size() - 1;
}

void ActionBus::wake() const {
  const std::uint64_t increment = 1;
  (void)!::write(event_, &increment, sizeof increment);
}

void ActionBus::reset() {
  topics_->reset();
  drain(event_);
  std::uint64_t periods = 0;
  if (::read(timer_, &periods, sizeof periods) != sizeof periods) return;
  for (const Action& action : actions_) {
    if (topics_->subscribers_of(action.status) > 0) publish_status(action);
  }
}

bool ActionBus::has_writer(std::size_t reader, const PeerId&) {
  return topics_->publishers_of(actions_[readers_[reader].action].goal) > 0;
}

std::size_t ActionBus::readers_of(std::size_t writer) {
  BIP_ASSERT(writers_[writer].part == Part::Poster, "readers of writer {}, which is no poster's", writer);
  return topics_->subscribers_of(writers_[writer].publisher);
}

// ---- what clients say

std::vector<Sample> ActionBus::take(std::size_t reader) {
  const End& end = readers_[reader];
  if (end.part == Part::SendGoal) return take_goals(end.action);
  if (end.part == Part::CancelGoal) return take_cancels(end.action);
  std::deque<Sample> wanted = std::exchange(actions_[end.action].wanted_results, {});
  return {std::make_move_iterator(wanted.begin()), std::make_move_iterator(wanted.end())};
}

std::vector<Sample> ActionBus::take_goals(std::size_t row) {
  const Action& action = actions_[row];
  std::vector<Sample> samples;
  for (const TopicMessage& message : topics_->take(action.goal)) {
    const Result<Json> asked = ros2::from_packed(types_.messages(), action.name + "ActionGoal", message.bytes);
    if (!asked) continue;  // the MD5 is the same on both ends: bytes of no client library
    const Json& goal_id = (*asked)["goal_id"];
    KnownGoal goal{.action = row, .id = goal_id["id"].get<std::string>(), .stamp = stamp_of(goal_id["stamp"])};
    if (goal.id.empty()) goal.id = fmt::format("{}-{}", action.name, next_id_++);
    if (goal.stamp == Stamp{}) goal.stamp = ros2::stamp_now();
    const GoalId id = bytes_of(action.name + " " + goal.id);
    const RequestHeader header{.client = 0, .number = next_number_++};
    const Result<Bytes> bytes =
        ros2::to_cdr(messages_, action.type + "_SendGoal_Request",
                     {{"goal_id", ros2::to_json(id)}, {"goal", std::move((*asked)["goal"])}}, &header);
    if (!bytes) continue;
    asked_[header.number] = id;
    goals_.try_emplace(id, std::move(goal));
    samples.push_back({*bytes, bytes_of(message.sender)});
  }
  return samples;
}

std::vector<Sample> ActionBus::take_cancels(std::size_t row) {
  const Action& action = actions_[row];
  std::vector<Sample> samples;
  for (const TopicMessage& message : topics_->take(action.cancel)) {
    const Result<Json> asked = ros2::from_packed(types_.messages(), "actionlib_msgs/GoalID", message.bytes);
    if (!asked) continue;
    const std::string id = (*asked)["id"].get<std::string>();
    const GoalId meant = id.empty() ? GoalId{} : bytes_of(action.name + " " + id);
    const RequestHeader header{.client = 0, .number = next_number_++};
    const Result<Bytes> bytes = ros2::to_cdr(
        messages_, "action_msgs/srv/CancelGoal_Request",
        {{"goal_info", {{"goal_id", ros2::to_json(meant)}, {"stamp", ros2::to_json(stamp_of((*asked)["stamp"]))}}}},
        &header);
    if (bytes) samples.push_back({*bytes, bytes_of(message.sender)});
  }
  return samples;
}

// ---- what the bridge says

std::string ActionBus::write(std::size_t writer, const Bytes& bytes) {
  const End& end = writers_[writer];
  if (end.part == Part::CancelGoal) return {};
  wrong_.clear();
  if (end.part == Part::Poster) {
    const Result<Json> value = ros2::from_cdr(messages_, end.message, bytes);
    if (!value) return value.error();
    publish(end.publisher, short_name(end.message), *value);
    return wrong_;
  }
  const std::string& type = actions_[end.action].type;
  const bool is_reply = end.part == Part::SendGoal || end.part == Part::GetResult;
  RequestHeader header;
  const std::string message = end.part == Part::SendGoal    ? type + "_SendGoal_Response"
                              : end.part == Part::GetResult ? type + "_GetResult_Response"
                              : end.part == Part::Feedback  ? type + "_FeedbackMessage"
                                                            : "action_msgs/msg/GoalStatusArray";
  const Result<Json> value = ros2::from_cdr(messages_, message, bytes, is_reply ? &header : nullptr);
  if (!value) return value.error();
  switch (end.part) {
    case Part::SendGoal: answer_goal(end.action, *value, header.number); break;
    case Part::GetResult: publish_result(end.action, *value, header.number); break;
    case Part::Feedback: publish_feedback(end.action, *value); break;
    case Part::Status: keep_status(end.action, (*value)["status_list"]); break;
    case Part::CancelGoal:
    case Part::Poster: BIP_UNREACHABLE("written above");
  }
  return wrong_;
}

void ActionBus::answer_goal(std::size_t row, const Json& reply, std::int64_t number) {
  const auto asked = asked_.extract(number);
  BIP_ASSERT(!asked.empty(), "an answer to request {}, which was not made", number);
  const GoalId id = asked.mapped();
  // The same id again: its first goal goes on, and has a result of its own.
  const auto goal = goals_.find(id);
  if (goal == goals_.end() || goal->second.has_result) return;
  if (!reply["accepted"].get<bool>()) goal->second.is_refused = true;
  goal->second.has_result = true;
  const RequestHeader header{.client = 0, .number = next_number_++};
  const Result<Bytes> bytes =
      ros2::to_cdr(messages_, actions_[row].type + "_GetResult_Request", {{"goal_id", ros2::to_json(id)}}, &header);
  if (!bytes) return;
  asked_[header.number] = id;
  actions_[row].wanted_results.push_back({*bytes, std::nullopt});
  wake();
}

Json ActionBus::status_row(const GoalId& id, std::uint8_t status, const std::string& text) const {
  const auto goal = goals_.find(id);
  // What the bridge has adopted is no client's goal.
  const Json goal_id = goal == goals_.end() ? Json{{"stamp", to_time({})}, {"id", text_of(id)}}
                                            : Json{{"stamp", to_time(goal->second.stamp)}, {"id", goal->second.id}};
  return {{"goal_id", goal_id}, {"status", status}, {"text", text}};
}

void ActionBus::publish_result(std::size_t row, const Json& reply, std::int64_t number) {
  const auto asked = asked_.extract(number);
  BIP_ASSERT(!asked.empty(), "a result of request {}, which was not made", number);
  const GoalId id = asked.mapped();
  const auto goal = goals_.find(id);
  const bool is_refused = goal != goals_.end() && goal->second.is_refused;
  const GoalStatus status = is_refused ? GoalStatus::Rejected : status_of(state_of(reply["status"]));
  const Json& result = reply["result"];
  const std::string report = result[ros2::kReport].get<std::string>();
  const std::string detail = result[ros2::kDetail].get<std::string>();
  publish(actions_[row].result, actions_[row].name + "ActionResult",
          {{"status", status_row(id, number_of(status), detail.empty() ? report : report + ": " + detail)},
           {"result", result}});
  // The status does not have it: nothing will speak of it again.
  if (is_refused) goals_.erase(goal);
}

void ActionBus::publish_feedback(std::size_t row, const Json& feedback) {
  publish(actions_[row].feedback, actions_[row].name + "ActionFeedback",
          {{"status", status_row(id_of(feedback["goal_id"]), number_of(GoalStatus::Active), "")},
           {"feedback", feedback["feedback"]}});
}

void ActionBus::keep_status(std::size_t row, const Json& list) {
  Action& action = actions_[row];
  action.statuses = Json::array();
  std::set<GoalId> there;
  for (const Json& status : list) {
    const GoalId id = id_of(status["goal_info"]["goal_id"]);
    there.insert(id);
    action.statuses.push_back(status_row(id, number_of(status_of(state_of(status["status"]))), ""));
  }
  publish_status(action);
  // What ended long ago the bridge has forgotten. What it has not decided yet is not in its status either.
  std::erase_if(goals_, [&](const auto& known) {
    return known.second.action == row && known.second.has_result && !known.second.is_refused &&
           !there.contains(known.first);
  });
}

void ActionBus::publish_status(const Action& action) {
  publish(action.status, "actionlib_msgs/GoalStatusArray", {{"status_list", action.statuses}});
}

void ActionBus::publish(std::size_t publisher, const std::string& type, Json value) {
  // What has a header says when it was made.
  if (!types_.messages().at(type).fields.empty() && types_.messages().at(type).fields[0].message == "std_msgs/Header")
    value["header"] = {{"stamp", to_time(ros2::stamp_now())}};
  const Result<Bytes> bytes = ros2::to_packed(types_.messages(), type, value);
  if (bytes) topics_->publish(publisher, *bytes);
  else wrong_ = bytes.error();
}

}  // namespace bip::ros1
