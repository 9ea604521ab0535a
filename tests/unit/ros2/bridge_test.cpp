// The bridge between a model and clients that are both made here: the order of what it says, and what it does when one
// side is late, silent or gone.
#include "compiler/ros2/bridge.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace bip::ros2 {
namespace {

constexpr const char* kType = "t_msgs/action/MGo";

// What a client of DDS would see.
class FakeBus final : public Bus {
 public:
  FakeBus() : event_(::eventfd(0, EFD_NONBLOCK)) {}
  ~FakeBus() override { ::close(event_); }
  Result<std::size_t> add_reader(const EndpointPlan& plan) override {
    readers.push_back(plan);
    waiting.emplace_back();
    return readers.size() - 1;
  }
  Result<std::size_t> add_writer(const EndpointPlan& plan) override {
    writers.push_back(plan);
    return writers.size() - 1;
  }
  [[nodiscard]] int descriptor() const override { return event_; }
  void reset() override {
    std::uint64_t ignored = 0;
    (void)!::read(event_, &ignored, sizeof ignored);
  }
  std::vector<Sample> take(std::size_t reader) override { return std::exchange(waiting[reader], {}); }
  std::string write(std::size_t writer, const Bytes& bytes) override {
    written.emplace_back(writers[writer].topic, bytes);
    return "";
  }
  bool has_reader(std::size_t, const PeerId&) override { return is_known; }
  bool has_writer(std::size_t, const PeerId&) override { return is_there; }
  std::size_t readers_of(std::size_t) override { return 1; }

  void send(const std::string& topic, Bytes bytes) {
    for (std::size_t k = 0; k < readers.size(); ++k) {
      if (readers[k].topic == topic) waiting[k].push_back({std::move(bytes), PeerId{1}});
    }
    const std::uint64_t one = 1;
    (void)!::write(event_, &one, sizeof one);
  }

  std::vector<EndpointPlan> readers, writers;
  std::vector<std::vector<Sample>> waiting;
  std::deque<std::pair<std::string, Bytes>> written;
  bool is_known = true, is_there = true;

 private:
  int event_;
};

// What listens at the socket, as `bipc serve` would.
class FakeModel {
 public:
  FakeModel() {
    char folder[] = "/tmp/bridge-XXXXXX";
    REQUIRE(::mkdtemp(folder) != nullptr);
    folder_ = folder;
    path = folder_ + "/s";
    open();
  }
  ~FakeModel() {
    close();
    ::unlink(path.c_str());
    ::rmdir(folder_.c_str());
  }
  void open() {
    ::unlink(path.c_str());
    listener_ = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), at.sun_path);
    REQUIRE(::bind(listener_, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0);
    REQUIRE(::listen(listener_, 1) == 0);
  }
  void close() {
    if (peer_ >= 0) ::close(peer_);
    if (listener_ >= 0) ::close(listener_);
    peer_ = listener_ = -1;
  }
  // The next line, without those that every client sends.
  Json line() {
    while (true) {
      if (peer_ < 0) peer_ = ::accept(listener_, nullptr, nullptr);
      const std::size_t end = received_.find('\n');
      if (end != std::string::npos) {
        const Json json = Json::parse(received_.substr(0, end));
        received_.erase(0, end + 1);
        return json;
      }
      pollfd waits{peer_, POLLIN, 0};
      if (::poll(&waits, 1, 100) == 0) return {};
      char buffer[4096];
      const ssize_t count = ::recv(peer_, buffer, sizeof buffer, 0);
      if (count <= 0) return {};
      received_.append(buffer, static_cast<std::size_t>(count));
    }
  }
  void say(const Json& json) {
    const std::string text = json.dump() + "\n";
    REQUIRE(::send(peer_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size()));
  }
  void answer(const Json& question, Json more = Json::object()) {
    more["id"] = question["id"];
    if (!more.contains("ok")) more["ok"] = true;
    say(more);
  }

  std::string path;

 private:
  std::string folder_, received_;
  int listener_ = -1, peer_ = -1;
};

struct Scene {
  Scene() {
    interfaces.package = "t_msgs";
    interfaces.messages.add_action(kType,
                                   {{.name = "power", .kind = Kind::Float64},
                                    {.name = "how", .kind = Kind::String},
                                    {.name = "input", .kind = Kind::String}},
                                   {{.name = kReport, .kind = Kind::String}, {.name = kDetail, .kind = Kind::String}},
                                   {{.name = kReport, .kind = Kind::String}, {.name = kDetail, .kind = Kind::String}});
    interfaces.actions.push_back(
        {.service = "M.Go", .name = "M/Go", .type = kType, .values = {"power", "how"}, .takes_text = true});
    bridge =
        std::make_unique<Bridge>(interfaces, bus, BridgeOptions{.where = model.path, .token = "", .name_space = "r1"},
                                 [this](const std::string& text) { said.push_back(text); });
    REQUIRE(bridge->open().empty());
    turn();
    greet(Json::array());
  }
  void greet(const Json& running) {
    const Json hello = model.line();
    REQUIRE(hello["do"] == "hello");
    CHECK(hello["role"] == "requester");
    model.answer(hello, {{"services", {{{"service", "M.Go"}}}}});
    turn();
    model.answer(model.line());  // subscribe
    model.answer(model.line(), {{"requests", running}});
    turn();
  }
  // Until there is nothing to do.
  void turn() {
    for (int k = 0; k < 3; ++k) bridge->turn(-1, std::chrono::milliseconds(5));
  }
  void goal(std::uint8_t id, const Json& goal) {
    const RequestHeader header{77, id};
    const Result<Bytes> bytes = to_cdr(interfaces.messages, std::string(kType) + "_SendGoal_Request",
                                       {{"goal_id", to_json(GoalId{id})}, {"goal", goal}}, &header);
    REQUIRE(bytes);
    bus.send("rq/r1/M/Go/_action/send_goalRequest", *bytes);
    turn();
  }
  void ask_result(std::uint8_t id) {
    const RequestHeader header{77, 100 + id};
    bus.send("rq/r1/M/Go/_action/get_resultRequest",
             *to_cdr(interfaces.messages, std::string(kType) + "_GetResult_Request", {{"goal_id", to_json(GoalId{id})}},
                     &header));
    turn();
  }
  // An id of zero and an instant: all goals that are older.
  void cancel(std::uint8_t id, const Stamp& instant = {}) {
    const RequestHeader header{77, 200 + id};
    bus.send("rq/r1/M/Go/_action/cancel_goalRequest",
             *to_cdr(interfaces.messages, "action_msgs/srv/CancelGoal_Request",
                     {{"goal_info", {{"goal_id", to_json(GoalId{id})}, {"stamp", to_json(instant)}}}}, &header));
    turn();
  }
  // A request of the bridge that is no sign of life.
  Json asked() {
    Json line = model.line();
    while (line.is_object() && line["do"] == "requests") line = model.line();
    return line;
  }
  // "TOPIC's end: VALUE" of the next sample.
  std::string heard() {
    if (bus.written.empty()) return "";
    const auto [topic, bytes] = bus.written.front();
    bus.written.pop_front();
    const auto read = [&](const std::string& type, bool has_header) {
      RequestHeader header;
      const Result<Json> value = from_cdr(interfaces.messages, type, bytes, has_header ? &header : nullptr);
      REQUIRE(value);
      CHECK((!has_header || header.client == 77));
      return *value;
    };
    if (topic.ends_with("send_goalReply"))
      return read(std::string(kType) + "_SendGoal_Response", true)["accepted"] == true ? "accepted" : "not accepted";
    if (topic.ends_with("cancel_goalReply"))
      return "cancelling " +
             std::to_string(read("action_msgs/srv/CancelGoal_Response", true)["goals_canceling"].size());
    if (topic.ends_with("get_resultReply")) {
      const Json value = read(std::string(kType) + "_GetResult_Response", true);
      return "result " + value["status"].dump() + " " + value["result"][kReport].get<std::string>();
    }
    if (topic.ends_with("feedback"))
      return "feedback " + read(std::string(kType) + "_FeedbackMessage", false)["feedback"][kReport].get<std::string>();
    std::string out = "status";
    const Json status = read("action_msgs/msg/GoalStatusArray", false);
    for (const Json& row : status["status_list"]) out += " " + row["status"].dump();
    return out;
  }
  std::string all_heard() {
    std::string out;
    while (!bus.written.empty()) out += (out.empty() ? "" : "; ") + heard();
    return out;
  }
  void note(std::uint64_t request, const char* reply, const char* report) {
    model.say({{"note", "request"}, {"request", request}, {"service", "M.Go"}, {"reply", reply}, {"report", report}});
    turn();
  }

  FakeModel model;
  FakeBus bus;
  Interfaces interfaces;
  std::vector<std::string> said;
  std::unique_ptr<Bridge> bridge;
};

const Json kGoal{{"power", 2.5}, {"how", "fast"}, {"input", "3 \"1\""}};

TEST_CASE("a goal from the request to the result") {
  Scene s;
  s.goal(1, kGoal);
  const Json request = s.asked();
  CHECK(request["do"] == "request");
  CHECK(request["service"] == "M.Go(2.5, fast)");
  CHECK(request["input"] == "3 \"1\"");
  s.model.answer(request, {{"request", 7}});
  s.turn();
  CHECK(s.all_heard().empty());
  s.note(7, "intermediate", "OK");
  CHECK(s.all_heard() == "accepted; status 2; feedback OK");
  s.ask_result(1);
  CHECK(s.all_heard().empty());
  s.note(7, "final", "OK");
  CHECK(s.all_heard() == "result 4 OK; status 4");
  s.ask_result(1);
  CHECK(s.all_heard() == "result 4 OK");
}

TEST_CASE("replies to a request may arrive before its number") {
  Scene s;
  s.goal(1, kGoal);
  const Json request = s.asked();
  s.note(7, "intermediate", "OK");
  s.note(7, "final", "BLOCKED");
  CHECK(s.all_heard().empty());
  s.model.answer(request, {{"request", 7}});
  s.turn();
  CHECK(s.all_heard() == "accepted; status 2; feedback OK; status 6");
}

TEST_CASE("a refusal: the reason, then the answer") {
  Scene s;
  s.goal(1, kGoal);
  s.model.answer(s.asked(), {{"request", 7}});
  s.note(7, "final", "TOO-MUCH");
  CHECK(s.all_heard() == "feedback TOO-MUCH; not accepted");
  s.ask_result(1);
  CHECK(s.all_heard() == "result 6 TOO-MUCH");
  s.goal(2, kGoal);
  s.model.answer(s.asked(), {{"ok", false}, {"error", "full"}});
  s.turn();
  CHECK(s.all_heard() == "feedback NOT-TAKEN; not accepted");
  // Over at once and well: a control service.
  s.goal(3, kGoal);
  s.model.answer(s.asked(), {{"request", 8}});
  s.note(8, "final", "OK");
  CHECK(s.all_heard() == "accepted; status 2; status 4");
}

TEST_CASE("words cannot say more than a value") {
  Scene s;
  for (const char* word : {"", "fast), M.Stop(", "a,b", "a b", "\n"}) {
    Json goal = kGoal;
    goal["how"] = word;
    s.goal(static_cast<std::uint8_t>(s.said.size()), goal);
    CHECK(s.all_heard() == "feedback NOT-TAKEN; not accepted");
  }
  Json goal = kGoal;
  goal["power"] = nullptr;  // not a number
  s.goal(99, goal);
  CHECK(s.all_heard() == "feedback NOT-TAKEN; not accepted");
  CHECK(s.asked().is_null());
}

TEST_CASE("samples that are no goals change nothing") {
  Scene s;
  for (const Bytes& bytes : {Bytes{}, Bytes{0, 1, 0}, Bytes{0, 1, 0, 0}, Bytes{0, 7, 0, 0, 1, 2, 3}, Bytes(40, 255)})
    s.bus.send("rq/r1/M/Go/_action/send_goalRequest", bytes);
  s.turn();
  CHECK(s.all_heard().empty());
  CHECK(s.asked().is_null());
  s.goal(1, kGoal);
  CHECK(s.asked()["do"] == "request");
}

TEST_CASE("a reply waits for the reader of its client") {
  Scene s;
  s.bus.is_known = false;
  s.ask_result(9);
  CHECK(s.all_heard().empty());
  s.bus.is_known = true;
  for (int k = 0; k < 20 && s.bus.written.empty(); ++k) s.turn();
  CHECK(s.all_heard() == "result 0 ");
}

TEST_CASE("a cancellation is asked for again while the module decides") {
  Scene s;
  s.goal(1, kGoal);
  s.model.answer(s.asked(), {{"request", 7}});
  s.turn();
  s.cancel(1);
  CHECK(s.all_heard() == "cancelling 1; status");
  Json cancel = s.asked();
  CHECK(cancel["request"] == 7);
  s.model.answer(cancel, {{"ok", false}, {"error", "the module is deciding about request 7: ask again"}});
  s.note(7, "intermediate", "OK");
  CHECK(s.all_heard() == "accepted; status 3; feedback OK");
  for (int k = 0; k < 20 && (cancel = s.asked()).is_null(); ++k) s.turn();
  CHECK(cancel["do"] == "cancel");
  s.model.answer(cancel);
  s.note(7, "final", "ACTIVITY_INTERRUPTED");
  CHECK(s.all_heard() == "status 5");
}

TEST_CASE("a cancellation of older goals does not mean one that came later and is not accepted yet") {
  Scene s;
  Stamp before = stamp_now();
  --before.seconds;
  s.goal(1, kGoal);
  s.cancel(0, before);
  CHECK(s.all_heard() == "cancelling 0");
  Stamp after = stamp_now();
  ++after.seconds;
  s.cancel(0, after);
  CHECK(s.all_heard() == "cancelling 1; status");
}

TEST_CASE("a model that goes and comes back") {
  Scene s;
  s.goal(1, kGoal);
  s.model.answer(s.asked(), {{"request", 7}});
  s.note(7, "intermediate", "OK");
  s.goal(2, kGoal);  // not answered yet
  s.ask_result(1);
  (void)s.all_heard();
  s.model.close();
  s.turn();
  CHECK(s.all_heard().find("result 6 CONTROLLER-LOST") != std::string::npos);
  REQUIRE_FALSE(s.said.empty());
  CHECK(std::any_of(s.said.begin(), s.said.end(),
                    [](const std::string& text) { return text.find("2 goals are aborted") != std::string::npos; }));
  s.goal(3, kGoal);
  CHECK(s.all_heard() == "feedback CONTROLLER-LOST; not accepted");
  s.model.open();
  for (int k = 0; k < 200 && s.said.back().find("connected") == std::string::npos; ++k) {
    s.turn();
    const Json line = k < 100 ? Json() : s.model.line();
    if (line.is_object() && line["do"] == "hello") s.model.answer(line, {{"services", Json::array()}});
  }
  CHECK(s.said.back().find("0 of 1 actions; the model does not have M.Go") != std::string::npos);
}

TEST_CASE("signs of life end with the clients") {
  Scene s;
  s.goal(1, kGoal);
  s.model.answer(s.asked(), {{"request", 7}});
  s.turn();
  s.bus.is_there = false;
  for (int k = 0; k < 100 && s.said.back().find("gone") == std::string::npos; ++k) s.turn();
  CHECK(s.said.back().find("all clients that sent goals are gone") != std::string::npos);
  while (s.model.line().is_object()) {
  }
  for (int k = 0; k < 50; ++k) s.turn();
  CHECK(s.model.line().is_null());
}

}  // namespace
}  // namespace bip::ros2
