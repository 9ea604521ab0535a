// See bridge.hpp.
#include "compiler/ros2/bridge.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "bip/assert.hpp"
#include "compiler/base/json_text.hpp"
#include "compiler/ros2/names.hpp"

namespace bip::ros2 {
namespace {

using namespace std::chrono_literals;

constexpr auto kTryAgain = 500ms;    // to connect
constexpr auto kSign = 200ms;        // of life, for `bipc serve --silent-after`
constexpr auto kCancelAgain = 20ms;  // while the module decides
constexpr auto kMostLate = 1s;       // a reply waits for its client's reader
constexpr auto kClean = 5s;
constexpr std::size_t kMostEarly = 1000;

constexpr const char* kLost = "CONTROLLER-LOST";
constexpr const char* kNotTaken = "NOT-TAKEN";

// A word in the parentheses of a request ends nothing there.
bool is_word(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.' || c == '+';
  });
}

GoalId id_of(const Json& goal_id) {
  GoalId id{};
  for (std::size_t k = 0; k < id.size(); ++k) id[k] = goal_id["uuid"][k].get<std::uint8_t>();
  return id;
}
Stamp stamp_of(const Json& stamp) { return {stamp["sec"].get<std::int32_t>(), stamp["nanosec"].get<std::uint32_t>()}; }

std::string text_of(const Json& line, const char* member) {
  const auto found = line.find(member);
  return found != line.end() && found->is_string() ? found->get<std::string>() : "";
}
std::uint64_t number_of(const Json& line, const char* member) {
  const auto found = line.find(member);
  return found != line.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

bool is_true(const Json& line, const char* member) {
  const auto found = line.find(member);
  return found != line.end() && *found == true;
}
Json list_of(const Json& line, const char* member) {
  const auto found = line.find(member);
  return found != line.end() && found->is_array() ? *found : Json::array();
}

// `bipc serve` closes the connection after a longer line, and its answer to a line that is too deep has no number.
constexpr std::size_t kLongestLine = 60000;
constexpr int kDeepestLine = 15;
int depth_of(const Json& json) {
  int deepest = 0;
  for (const Json& item : json) {
    if (item.is_structured()) deepest = std::max(deepest, depth_of(item));
  }
  return deepest + 1;
}

}  // namespace

Bridge::Bridge(const Interfaces& interfaces, Bus& bus, BridgeOptions options,
               std::function<void(const std::string&)> say)
    : interfaces_(interfaces), bus_(bus), options_(std::move(options)), say_(std::move(say)) {}

std::string Bridge::open() {
  BIP_ASSERT(ends_.empty() && posters_.empty(), "{} actions are open already", ends_.size());
  const Messages& messages = interfaces_.messages;
  const std::string in_front = options_.name_space.empty() ? "" : options_.name_space + "/";
  std::string wrong;
  enum class EndpointKind : std::uint8_t { Reader, Writer };
  const auto add = [&](EndpointKind kind, const EndpointPlan& plan) -> std::size_t {
    if (!wrong.empty()) return 0;
    const Result<std::size_t> made = kind == EndpointKind::Reader ? bus_.add_reader(plan) : bus_.add_writer(plan);
    if (made) return *made;
    wrong = made.error();
    return 0;
  };
  for (const Action& action : interfaces_.actions) {
    const std::string name = in_front + action.name + "/_action/";
    Ends ends;
    const auto service = [&](const char* of, const std::string& type, std::size_t& request, std::size_t& answer) {
      const std::string id = make_service_id();
      request = add(EndpointKind::Reader, service_plan(messages, name + of, type, Half::Request, id));
      answer = add(EndpointKind::Writer, service_plan(messages, name + of, type, Half::Reply, id));
    };
    service("send_goal", action.type + "_SendGoal", ends.send_goal, ends.send_goal_reply);
    service("cancel_goal", "action_msgs/srv/CancelGoal", ends.cancel_goal, ends.cancel_goal_reply);
    service("get_result", action.type + "_GetResult", ends.get_result, ends.get_result_reply);
    ends.feedback =
        add(EndpointKind::Writer, topic_plan(messages, name + "feedback", action.type + "_FeedbackMessage"));
    EndpointPlan status = topic_plan(messages, name + "status", "action_msgs/msg/GoalStatusArray");
    status.depth = 1;
    status.keep = Keep::LastForLateJoiners;
    ends.status = add(EndpointKind::Writer, status);
    ends_.push_back(ends);
  }
  for (const Topic& topic : interfaces_.topics) {
    EndpointPlan plan = topic_plan(messages, in_front + topic.name, topic.type);
    plan.keep = Keep::LastForLateJoiners;
    plan.depth = 1;
    posters_.push_back({.writer = add(EndpointKind::Writer, plan)});
  }
  return wrong;
}

void Bridge::run(int stop) {
  while (true) {
    turn(stop, 1000ms);
    pollfd is_over{stop, POLLIN, 0};
    if (::poll(&is_over, 1, 0) > 0) return;
  }
}

void Bridge::turn(int stop, std::chrono::milliseconds longest) {
  Clock::time_point now = Clock::now(), until = now + longest;
  if (!model_) until = std::min(until, next_try_);
  else until = std::min(until, next_sign_);
  if (is_ready_ && !posters_.empty()) until = std::min(until, next_value_);
  if (!cancels_.empty() || !late_.empty()) until = std::min(until, now + kCancelAgain);
  const auto wait = std::chrono::ceil<std::chrono::milliseconds>(std::max(until - now, Clock::duration(0)));
  pollfd waits[] = {{stop, POLLIN, 0}, {bus_.descriptor(), POLLIN, 0}, {model_ ? model_->descriptor() : -1, POLLIN, 0}};
  (void)::poll(waits, std::size(waits), static_cast<int>(wait.count()));
  if (waits[1].revents != 0) {
    bus_.reset();
    take_all();
  }
  if (model_ && waits[2].revents != 0) {
    std::vector<std::string> lines;
    const bool is_open = model_->receive(lines);
    for (const std::string& line : lines) {
      if (model_) hear(line);
    }
    if (!is_open && model_) lose("the connection is closed");
  }
  if (model_ && !model_->flush()) lose("it does not read");
  keep_time(Clock::now());
}

void Bridge::keep_time(Clock::time_point now) {
  if (!model_ && now >= next_try_) connect();
  send_late(now);
  if (now >= next_cancel_) {
    next_cancel_ = now + kCancelAgain;
    for (const GoalId& id : std::exchange(cancels_, {})) {
      if (Goal* const goal = goals_.find(id); goal != nullptr && !is_over(goal->state)) cancel(*goal);
    }
  }
  if (model_ && now >= next_sign_) {
    next_sign_ = now + kSign;
    // The decisional level has fallen silent when its clients are gone: then the bridge does, too.
    if (has_clients() && is_ready_) ask({{"do", "requests"}}, {.kind = ServerRequest::Sign});
  }
  if (is_ready_ && now >= next_value_) {
    next_value_ = now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / options_.rate));
    for (std::size_t k = 0; k < posters_.size(); ++k) {
      if (posters_[k].is_asked || bus_.readers_of(posters_[k].writer) == 0) continue;
      ask_poster(k);
    }
  }
  if (now >= next_clean_) {
    next_clean_ = now + kClean;
    for (const std::size_t action : goals_.forget(now)) publish_status(action);
  }
}

// ---- the model

void Bridge::connect() {
  next_try_ = Clock::now() + kTryAgain;
  auto opened = live::ModelConnection::open(options_.where, options_.token);
  if (!opened) {
    if (!was_lost_)
      say_(fmt::format("warning[R0080]: no `bipc serve` at {} ({}): trying again", options_.where, opened.error()));
    was_lost_ = true;
    return;
  }
  model_ = std::move(*opened);
  next_sign_ = Clock::now() + kSign;
  Json hello{{"do", "hello"}, {"role", "requester"}};
  if (!model_->token().empty()) hello["token"] = model_->token();
  ask(std::move(hello), {.kind = ServerRequest::Hello});
}

void Bridge::lose(const std::string& why) {
  model_.reset();
  is_ready_ = false;
  was_lost_ = true;
  questions_.clear();
  early_.clear();
  cancels_.clear();
  for (Poster& p : posters_) p.is_asked = false;
  next_try_ = Clock::now() + kTryAgain;
  const std::vector<Goal*> open = goals_.open();
  say_(fmt::format("warning[R0080]: `bipc serve` at {} is gone ({}): {} goal{} aborted, trying again", options_.where,
                   why, open.size(), open.size() == 1 ? " is" : "s are"));
  for (Goal* const goal : open) abort(*goal, kLost);
}

void Bridge::ask(Json line, Question question) {
  if (!model_) return;
  line["id"] = next_question_;
  questions_.emplace(next_question_++, question);
  if (!model_->send(json_line(line))) lose("it does not read");
}

void Bridge::hear(const std::string& line) {
  const Json json = parse_json(line);
  if (!json.is_object()) return;
  if (json.contains("note")) return hear_note(json);
  const auto found = questions_.find(number_of(json, "id"));
  if (found == questions_.end()) {
    // Before it knows us the model answers without a number.
    if (!is_ready_ && !is_true(json, "ok")) lose(text_of(json, "error"));
    return;
  }
  const Question question = found->second;
  questions_.erase(found);
  hear_answer(question, json);
}

void Bridge::hear_answer(const Question& question, const Json& answer) {
  const bool is_ok = is_true(answer, "ok");
  const std::string error = text_of(answer, "error");
  switch (question.kind) {
    case ServerRequest::Hello: return is_ok ? begin(answer) : lose(error);
    case ServerRequest::Open: return is_ok ? adopt(list_of(answer, "requests")) : void();
    case ServerRequest::Subscribe:
    case ServerRequest::Sign: return;
    case ServerRequest::Poster: return publish_poster(question.poster, answer);
    case ServerRequest::Goal: {
      Goal* const goal = goals_.find(question.goal);
      if (goal == nullptr) return;
      if (!is_ok) return refuse(*goal, kNotTaken, error);
      goal->request = number_of(answer, "request");
      if (goal->is_cancel_asked) cancel(*goal);
      // Its replies may have arrived before its number.
      const std::vector<Json> early = std::exchange(early_, {});
      for (const Json& note : early) hear_note(note);
      return;
    }
    case ServerRequest::Cancel: {
      Goal* const goal = goals_.find(question.goal);
      if (is_ok || goal == nullptr || is_over(goal->state)) return;
      if (error.ends_with("ask again")) return cancels_.push_back(question.goal);
      say_(fmt::format("cancel  {}: {}", service_of(*goal), error));
      if (goal->state == GoalState::Canceling) {
        goal->state = GoalState::Executing;
        publish_status(goal->action);
      }
      return;
    }
  }
}

void Bridge::hear_note(const Json& note) {
  const std::string kind = text_of(note, "note");
  if (kind == "end") return say_("the model has ended: " + text_of(note, "text"));
  if (kind == "stalled" || kind == "runs again" || kind == "stopped") return say_("model   " + text_of(note, "text"));
  if (kind != "request") return;
  Goal* const goal = goals_.find_request(number_of(note, "request"));
  if (goal == nullptr) {
    const bool may_be_ours = std::any_of(questions_.begin(), questions_.end(),
                                         [](const auto& row) { return row.second.kind == ServerRequest::Goal; });
    if (may_be_ours && early_.size() < kMostEarly) early_.push_back(note);
    return;
  }
  if (text_of(note, "reply") == "final") return finish(*goal, note);
  accept(*goal);
  publish_feedback(*goal, text_of(note, "report"), "");
}

void Bridge::begin(const Json& hello) {
  is_ready_ = true;
  was_lost_ = false;
  next_value_ = Clock::now();
  std::set<std::string> served;
  for (const Json& row : list_of(hello, "services")) served.insert(text_of(row, "service"));
  std::string missing;
  std::size_t count = 0;
  for (const Action& action : interfaces_.actions) {
    if (served.contains(action.service)) ++count;
    else missing += (missing.empty() ? "" : ", ") + action.service;
  }
  say_(fmt::format("connected to {}: {} of {} actions{}", options_.where, count, interfaces_.actions.size(),
                   missing.empty() ? "" : "; the model does not have " + missing));
  ask({{"do", "subscribe"}, {"requests", true}}, {.kind = ServerRequest::Subscribe});
  ask({{"do", "requests"}}, {.kind = ServerRequest::Open});
  // Once, to say at the beginning which posters will never come.
  unknown_posters_ = posters_.size();
  hidden_posters_.clear();
  for (std::size_t k = 0; k < posters_.size(); ++k) {
    posters_[k].is_known = false;
    ask_poster(k);
  }
}

void Bridge::ask_poster(std::size_t k) {
  BIP_ASSERT(posters_.size() == interfaces_.topics.size(), "{} posters of {} topics", posters_.size(),
             interfaces_.topics.size());
  posters_[k].is_asked = true;
  ask({{"do", "poster"}, {"poster", interfaces_.topics[k].poster}}, {.kind = ServerRequest::Poster, .poster = k});
}

// An activity that runs already was requested by another client, perhaps by an earlier bridge. It becomes a goal with a
// new id, so that clients see it and can cancel it.
void Bridge::adopt(const Json& rows) {
  std::random_device random;
  for (const Json& row : rows) {
    const std::string service = text_of(row, "service");
    if (goals_.find_request(number_of(row, "request")) != nullptr) continue;
    for (std::size_t k = 0; k < interfaces_.actions.size(); ++k) {
      if (interfaces_.actions[k].service != service || !is_true(row, "running")) continue;
      GoalId id{};
      for (std::uint8_t& byte : id) byte = static_cast<std::uint8_t>(random());
      Goal* const goal = goals_.add(k, id);
      if (goal == nullptr) continue;
      goal->request = number_of(row, "request");
      goal->state = GoalState::Executing;
      goal->accepted = stamp_now();
      say_(fmt::format("adopted {}: it runs already", service));
      publish_status(k);
    }
  }
}

// ---- clients

void Bridge::take_all() {
  for (std::size_t k = 0; k < ends_.size(); ++k) {
    for (const Sample& sample : bus_.take(ends_[k].send_goal)) take_goal(k, sample);
    for (const Sample& sample : bus_.take(ends_[k].cancel_goal)) take_cancel(k, sample);
    for (const Sample& sample : bus_.take(ends_[k].get_result)) take_result(k, sample);
  }
}

std::string Bridge::request_of(const Action& action, const Json& goal, Json& input, std::string& wrong) const {
  std::string values;
  input = goal;
  for (const std::string& name : action.values) {
    const Json& value = goal[name];
    if (std::find(action.shared_values.begin(), action.shared_values.end(), name) == action.shared_values.end())
      input.erase(name);
    if (!value.is_string() && !value.is_number()) wrong = fmt::format("`{}` is no number", name);
    else if (value.is_string() && !is_word(value.get<std::string>())) wrong = fmt::format("`{}` is no word", name);
    else
      values += (values.empty() ? "" : ", ") +
                (value.is_string() ? value.get<std::string>() : fmt::format("{}", value.get<double>()));
  }
  if (action.takes_text) input = goal[kInput];
  return action.service + (values.empty() ? "" : "(" + values + ")");
}

void Bridge::take_goal(std::size_t k, const Sample& sample) {
  const Action& action = interfaces_.actions[k];
  Asker asker{{}, sample.peer};
  const Result<Json> asked =
      from_cdr(interfaces_.messages, action.type + "_SendGoal_Request", sample.bytes, &asker.header);
  if (!asked) return say_(fmt::format("a goal of {} cannot be read: {}", action.service, asked.error()));
  if (sample.peer) {
    clients_.insert({ends_[k].send_goal, *sample.peer});
    had_clients_ = true;
  }
  Goal* const goal = goals_.add(k, id_of((*asked)["goal_id"]));
  if (goal == nullptr) {
    // The same goal twice: the first one stays what it is.
    return reply(ends_[k].send_goal_reply, action.type + "_SendGoal_Response", {{"accepted", false}}, asker);
  }
  goal->asker = asker;
  // Until it is accepted: a cancellation of what is older than an instant does not mean goals that came after that.
  goal->accepted = stamp_now();
  if (!is_ready_) return refuse(*goal, kLost, "there is no `bipc serve`");
  Json input;
  std::string wrong;
  const std::string text = request_of(action, (*asked)["goal"], input, wrong);
  if (!wrong.empty()) return refuse(*goal, kNotTaken, wrong);
  const Json line{{"do", "request"}, {"service", text}, {"input", input}};
  if (depth_of(line) > kDeepestLine || json_line(line).size() > kLongestLine)
    return refuse(*goal, kNotTaken, "the goal is larger than a request may be");
  ask(line, {.kind = ServerRequest::Goal, .goal = goal->id});
}

void Bridge::take_cancel(std::size_t k, const Sample& sample) {
  Asker asker{{}, sample.peer};
  const Result<Json> asked =
      from_cdr(interfaces_.messages, "action_msgs/srv/CancelGoal_Request", sample.bytes, &asker.header);
  if (!asked) return say_(fmt::format("a cancellation cannot be read: {}", asked.error()));
  const Json& info = (*asked)["goal_info"];
  CancelCode code = CancelCode::None;
  const std::vector<Goal*> chosen = goals_.select(k, {id_of(info["goal_id"]), stamp_of(info["stamp"])}, code);
  Json list = Json::array();
  for (Goal* const goal : chosen) {
    list.push_back({{"goal_id", to_json(goal->id)}, {"stamp", to_json(goal->accepted)}});
    if (goal->state == GoalState::Executing) goal->state = GoalState::Canceling;
    if (!std::exchange(goal->is_cancel_asked, true)) say_("cancel  " + service_of(*goal));
    if (goal->request != 0) cancel(*goal);
  }
  reply(ends_[k].cancel_goal_reply, "action_msgs/srv/CancelGoal_Response",
        {{"return_code", static_cast<int>(code)}, {"goals_canceling", std::move(list)}}, asker);
  if (!chosen.empty()) publish_status(k);
}

void Bridge::take_result(std::size_t k, const Sample& sample) {
  const Action& action = interfaces_.actions[k];
  Asker asker{{}, sample.peer};
  const Result<Json> asked =
      from_cdr(interfaces_.messages, action.type + "_GetResult_Request", sample.bytes, &asker.header);
  if (!asked) return say_(fmt::format("a request for a result cannot be read: {}", asked.error()));
  Goal* const goal = goals_.find(id_of((*asked)["goal_id"]));
  if (goal == nullptr || goal->action != k) {
    return reply(ends_[k].get_result_reply, action.type + "_GetResult_Response",
                 {{"status", static_cast<int>(GoalState::Unknown)}, {"result", Json::object()}}, asker);
  }
  goal->awaiting.push_back(asker);
  if (is_over(goal->state)) answer_results(*goal);
}

// ---- goals

const std::string& Bridge::service_of(const Goal& goal) const { return interfaces_.actions[goal.action].service; }

void Bridge::answer_acceptance(Goal& goal, bool is_accepted) {
  if (!goal.asker) return;
  reply(ends_[goal.action].send_goal_reply, interfaces_.actions[goal.action].type + "_SendGoal_Response",
        {{"accepted", is_accepted}, {"stamp", to_json(goal.accepted)}}, *goal.asker);
  goal.asker.reset();
}

void Bridge::accept(Goal& goal) {
  if (goal.state != GoalState::Unknown) return;
  goal.state = goal.is_cancel_asked ? GoalState::Canceling : GoalState::Executing;
  goal.accepted = stamp_now();
  answer_acceptance(goal, true);
  publish_status(goal.action);
  say_("accepted " + service_of(goal));
}

// The reason comes first: a client that hears of the refusal has it then, or fetches it as a result.
void Bridge::refuse(Goal& goal, const std::string& report, const std::string& detail) {
  goal.is_refused = true;
  goal.result = {{kReport, report}, {kDetail, detail}};
  publish_feedback(goal, report, detail);
  answer_acceptance(goal, false);
  say_(fmt::format("refused  {}: {}{}", service_of(goal), report, detail.empty() ? "" : " (" + detail + ")"));
  end(goal, GoalState::Aborted);
}

void Bridge::finish(Goal& goal, const Json& note) {
  const std::string report = text_of(note, "report");
  const auto exception = note.find("exception");
  const std::string detail = exception == note.end() ? "" : exception->dump();
  // What never began, unless it was over at once.
  if (goal.state == GoalState::Unknown && report != "OK") return refuse(goal, report, detail);
  accept(goal);
  const auto output = note.find("output");
  goal.result = output != note.end() && output->is_object() ? *output : Json::object();
  goal.result[kReport] = report;
  goal.result[kDetail] = detail;
  say_(fmt::format("ended    {}: {}", service_of(goal), report));
  end(goal, report == "OK" ? GoalState::Succeeded
            : goal.is_cancel_asked && (report == "ACTIVITY_INTERRUPTED" || report == "interrupted")
                ? GoalState::Canceled
                : GoalState::Aborted);
}

void Bridge::abort(Goal& goal, const std::string& report) {
  if (goal.state == GoalState::Unknown) return refuse(goal, report, "");
  goal.result = {{kReport, report}, {kDetail, ""}};
  end(goal, GoalState::Aborted);
}

void Bridge::end(Goal& goal, GoalState state) {
  BIP_ASSERT(!is_over(goal.state) && is_over(state), "a goal of {} ends from {} to {}", service_of(goal), goal.state,
             state);
  goal.state = state;
  goal.ended = Clock::now();
  answer_results(goal);
  if (!goal.is_refused) publish_status(goal.action);
}

void Bridge::cancel(Goal& goal) {
  if (model_) ask({{"do", "cancel"}, {"request", goal.request}}, {.kind = ServerRequest::Cancel, .goal = goal.id});
}

void Bridge::answer_results(Goal& goal) {
  for (const Asker& asker : std::exchange(goal.awaiting, {}))
    reply(ends_[goal.action].get_result_reply, interfaces_.actions[goal.action].type + "_GetResult_Response",
          {{"status", static_cast<int>(goal.state)}, {"result", goal.result}}, asker);
}

void Bridge::publish_status(std::size_t action) {
  write(ends_[action].status, "action_msgs/msg/GoalStatusArray", goals_.status_of(action));
}

void Bridge::publish_feedback(const Goal& goal, const std::string& report, const std::string& detail) {
  write(ends_[goal.action].feedback, interfaces_.actions[goal.action].type + "_FeedbackMessage",
        {{"goal_id", to_json(goal.id)}, {"feedback", {{kReport, report}, {kDetail, detail}}}});
}

// ---- writing

void Bridge::publish_poster(std::size_t k, const Json& answer) {
  Poster& poster = posters_[k];
  const Topic& topic = interfaces_.topics[k];
  poster.is_asked = false;
  BIP_ASSERT(poster.is_known || unknown_posters_ > 0, "poster {} answers, and none is waited for", topic.poster);
  std::string wrong = text_of(answer, "error");
  if (!std::exchange(poster.is_known, true)) {
    if (!wrong.empty()) {
      poster.has_complained = true;
      hidden_posters_ += (hidden_posters_.empty() ? "" : ", ") + topic.poster;
      hidden_why_ = wrong;
    }
    if (--unknown_posters_ == 0 && !hidden_posters_.empty())
      say_(fmt::format("warning[R0081]: not published: {}: {}", hidden_posters_, hidden_why_));
  }
  const auto value = answer.find("value");
  if (wrong.empty() && (value == answer.end() || value->is_null())) return;  // nothing was written yet
  if (wrong.empty()) {
    const Result<Bytes> bytes =
        to_cdr(interfaces_.messages, topic.type, topic.is_bare ? Json{{kData, *value}} : *value);
    wrong = bytes ? bus_.write(poster.writer, *bytes) : bytes.error();
  }
  if (wrong.empty() || std::exchange(poster.has_complained, true)) return;
  say_(fmt::format("warning[R0081]: poster {} is not published: {}", topic.poster, wrong));
}

void Bridge::write(std::size_t writer, const std::string& type, const Json& value) {
  const Result<Bytes> bytes = to_cdr(interfaces_.messages, type, value);
  const std::string wrong = bytes ? bus_.write(writer, *bytes) : bytes.error();
  if (!wrong.empty()) say_(fmt::format("warning[R0081]: {} is not sent: {}", type, wrong));
}

void Bridge::reply(std::size_t writer, const std::string& type, const Json& value, const Asker& asker) {
  const Result<Bytes> bytes = to_cdr(interfaces_.messages, type, value, &asker.header);
  if (!bytes) return say_(fmt::format("warning[R0081]: {} is not sent: {}", type, bytes.error()));
  if (asker.peer && !bus_.has_reader(writer, *asker.peer)) {
    late_.push_back({writer, *bytes, *asker.peer, Clock::now() + kMostLate});
    return;
  }
  if (const std::string wrong = bus_.write(writer, *bytes); !wrong.empty())
    say_(fmt::format("warning[R0081]: {} is not sent: {}", type, wrong));
}

void Bridge::send_late(Clock::time_point now) {
  std::erase_if(late_, [&](const LateReply& reply) {
    if (now >= reply.until) return true;
    if (!bus_.has_reader(reply.writer, reply.peer)) return false;
    (void)bus_.write(reply.writer, reply.bytes);
    return true;
  });
}

// Before the first goal the bridge counts as a client itself.
bool Bridge::has_clients() {
  std::erase_if(clients_, [&](const Client& client) { return !bus_.has_writer(client.reader, client.peer); });
  const bool are_gone = had_clients_ && clients_.empty();
  if (are_gone && !clients_are_gone_)
    say_("warning[R0080]: all clients that sent goals are gone: no more signs of life to `bipc serve`");
  clients_are_gone_ = are_gone;
  return !are_gone;
}

}  // namespace bip::ros2
