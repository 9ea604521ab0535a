// The bridge between a running `bipc serve` and ROS 2 (compiler/docs/ros2.md): an action server for each service of
// robot modules, a topic for each poster.
//
// One thread: it waits for lines of the model and samples of DDS, and answers both. Either side may go and come back.
// A client that is slow costs nothing; what it has asked for is kept for a minute.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "compiler/live/model_connection.hpp"
#include "compiler/ros2/bus.hpp"
#include "compiler/ros2/goals.hpp"
#include "compiler/ros2/interfaces.hpp"

namespace bip::ros2 {

struct BridgeOptions {
  std::string where, token;  // of `bipc serve`
  std::string name_space;    // in front of names; empty: none
  double rate = 10;          // values of a poster per second
};

class Bridge {
 public:
  /// `interfaces` and `bus` live longer. `say` gets a line for each event.
  Bridge(const Interfaces& interfaces, Bus& bus, BridgeOptions options, std::function<void(const std::string&)> say);
  /// Makes readers and writers. Returns an empty text, or what went wrong.
  [[nodiscard]] std::string open();
  /// Until `stop` can be read.
  void run(int stop);
  /// One round: waits until something happens, at most so long. For run(), and for tests.
  void turn(int stop, std::chrono::milliseconds longest);

 private:
  struct Ends {  // of an action
    std::size_t send_goal = 0, cancel_goal = 0, get_result = 0;
    std::size_t send_goal_reply = 0, cancel_goal_reply = 0, get_result_reply = 0, feedback = 0, status = 0;
  };
  struct Poster {
    std::size_t writer = 0;
    bool is_asked = false, is_known = false, has_complained = false;
  };
  /// A reply whose client's reader is not found yet.
  struct LateReply {
    std::size_t writer;
    Bytes bytes;
    PeerId peer;
    Clock::time_point until;
  };
  enum class ServerRequest : std::uint8_t { Hello, Subscribe, Open, Goal, Cancel, Poster, Sign };
  struct Question {
    ServerRequest kind = ServerRequest::Hello;
    GoalId goal{};
    std::size_t poster = 0;
  };

  // ---- the model
  void connect();
  void lose(const std::string& why);
  void ask(Json line, Question question);
  void hear(const std::string& line);
  void hear_answer(const Question& question, const Json& answer);
  void hear_note(const Json& note);
  void begin(const Json& hello);
  void adopt(const Json& rows);

  // ---- clients
  void take_all();
  void take_goal(std::size_t action, const Sample& sample);
  void take_cancel(std::size_t action, const Sample& sample);
  void take_result(std::size_t action, const Sample& sample);
  /// The text of a request and its input; empty text: the goal cannot be asked for, `wrong` says why.
  [[nodiscard]] std::string request_of(const Action& action, const Json& goal, Json& input, std::string& wrong) const;

  // ---- goals
  void accept(Goal& goal);
  void refuse(Goal& goal, const std::string& report, const std::string& detail);
  void finish(Goal& goal, const Json& note);
  void abort(Goal& goal, const std::string& report);
  void end(Goal& goal, GoalState state);
  void cancel(Goal& goal);
  void answer_acceptance(Goal& goal, bool is_accepted);
  void answer_results(Goal& goal);
  void publish_status(std::size_t action);
  void publish_feedback(const Goal& goal, const std::string& report, const std::string& detail);

  void publish_poster(std::size_t topic, const Json& answer);
  void ask_poster(std::size_t topic);
  void reply(std::size_t writer, const std::string& type, const Json& value, const Asker& asker);
  void write(std::size_t writer, const std::string& type, const Json& value);
  void send_late(Clock::time_point now);
  void keep_time(Clock::time_point now);
  [[nodiscard]] bool has_clients();
  [[nodiscard]] const std::string& service_of(const Goal& goal) const;

  const Interfaces& interfaces_;
  Bus& bus_;
  BridgeOptions options_;
  std::function<void(const std::string&)> say_;
  std::vector<Ends> ends_;       // of interfaces_.actions
  std::vector<Poster> posters_;  // of interfaces_.topics
  std::unique_ptr<live::ModelConnection> model_;
  bool is_ready_ = false;  // the model has said what it has
  bool was_lost_ = false;
  std::size_t unknown_posters_ = 0;  // of which it has not said whether it shows them
  std::string hidden_posters_, hidden_why_;
  std::map<std::uint64_t, Question> questions_;
  std::uint64_t next_question_ = 1;
  std::vector<Json> early_;  // notes that arrived before the answer with their request's number
  Goals goals_;
  std::vector<GoalId> cancels_;  // to be asked for again
  std::vector<LateReply> late_;
  struct Client {
    std::size_t reader;
    PeerId peer;
    auto operator<=>(const Client&) const = default;
  };
  std::set<Client> clients_;  // that have sent a goal and are there
  bool had_clients_ = false, clients_are_gone_ = false;
  Clock::time_point next_try_, next_sign_, next_value_, next_clean_, next_cancel_;
};

}  // namespace bip::ros2
