// A model that `bipc serve` runs, as pages see it (`bipc view --attach`): a client of its protocol on one side, the
// requests and notes of pages on the other.
//
// What the model does is looked at while it goes on: notes of its steps are collected, and then the components that
// took part are asked for, at most kLooksPerSecond times a second, so that the model is disturbed by what moves, not by
// its size. A row of the run is a step; places and data change with the last step of a look. More steps than
// kMostStepsOfLook are one row. Steps that are undone stay in the run, with a row that says so: it is what was seen.
//
//   {"id": 1, "do": "pause"}, "resume"                      as in compiler/docs/serve.md, of operators
//   {"id": 2, "do": "step", "count": 1}, "back"
//   {"id": 3, "do": "fire", "candidate": 0, "steps": 7}     refused if the model has taken another number of steps
//   {"id": 4, "do": "break", "path": "table.left[0]"}       of an interaction or a port; an empty one: none
//   {"id": 5, "do": "post", "port": "panel.turn", "values": "3 true"}
//   {"id": 6, "do": "why", "path": "table.left[0]"}
// Answers: as those of a live session. Notes: "run" (live_session.hpp); its `candidates` are null in states of a model
// that went on. With it, and alone:
//   {"note": "model", "paused": …, "ended": …, "time": ns, "steps": n, "late": n}
//   {"note": "begin", "places": […], "data": […], "clocks": […], "time": ns, "candidates": […], "names": […]}     the
//   run is forgotten
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "compiler/base/result.hpp"
#include "compiler/live/model_connection.hpp"
#include "compiler/live/page_session.hpp"

namespace bip {
struct System;
}

namespace bip::live {

class AttachedSession final : public PageSession {
 public:
  using Json = nlohmann::ordered_json;
  static constexpr std::size_t kMostRows = 100'000, kMostAtoms = 1000;
  static constexpr int kLooksPerSecond = 10;
  static constexpr std::size_t kMostStepsOfLook = 50;

  /// The system is that of the model, and must outlive this.
  AttachedSession(const System& system, std::unique_ptr<ModelConnection> connection);

  /// Says hello, compares the model with the system, and looks at its state; waits for at most ten seconds for each
  /// answer. Empty, or what is wrong.
  [[nodiscard]] std::string begin();
  /// The run without steps, for a page that is made (view/page.hpp); a page gets all else by greet().
  [[nodiscard]] const Json& initial() const { return initial_; }
  /// What this client may do: "observer", "requester", "operator".
  [[nodiscard]] const std::string& role() const { return role_; }

  void greet(std::uint64_t page) override;
  [[nodiscard]] bool handle(std::uint64_t page, std::string_view message) override;
  void leave(std::uint64_t page) override;
  [[nodiscard]] int descriptor() const override { return connection_->descriptor(); }
  [[nodiscard]] bool hear() override;
  [[nodiscard]] bool tick() override;

 private:
  using Clock = std::chrono::steady_clock;
  struct Row {
    std::string step, candidates;  // texts of JSON; of the state after the step
  };
  /// A step that the model told of, and that no look has shown so far.
  struct ReportedStep {
    std::uint64_t number = 0;
    std::string text, values;
    std::int64_t connector = -1, time = 0;
    Json parts;
  };

  [[nodiscard]] Json ask_now(const Json& request);
  [[nodiscard]] bool ask(Json request, std::function<void(const Json&)> then);
  /// As ask(), of the session itself: without it nothing more is seen, so a failure ends the session.
  void ask_or_end(Json request, std::function<void(const Json&)> then);
  void hear_line(const std::string& line);
  void hear_step(const Json& note);
  void look();
  void see(const Json& answer);
  void see_candidates(const Json& answer);
  void add_row(const std::string& step);
  void begin_again();
  void note_model(const Json& state);
  void tell();
  [[nodiscard]] Json changes(const Json& atoms, std::int64_t until, Json& set_clocks);
  [[nodiscard]] std::size_t name_row(const std::string& name);
  [[nodiscard]] std::string read_state(const Json& answer);
  [[nodiscard]] Json begin_note() const;
  [[nodiscard]] std::string run_note(std::size_t from, std::size_t to, std::size_t names_from) const;
  void find_port(const std::string& port, std::int64_t& atom, std::int64_t& row) const;

  const System& system_;
  std::unique_ptr<ModelConnection> connection_;
  std::map<std::string, std::size_t> atoms_, connectors_;  // by path
  std::string role_;
  Json initial_;
  // What the model was when it was looked at last.
  std::vector<std::string> places_;
  std::vector<std::vector<std::string>> data_;
  std::vector<Json> clocks_;  // by component: of each clock value, since, speed
  Json model_ = Json::object();
  // The run: the state at its begin, rows, the candidates after the last one.
  Json first_;
  std::string first_candidates_ = "null";
  std::vector<Row> rows_;
  std::int64_t row_time_ = 0;  // the instant of the last row, or of the state at the begin
  std::map<std::string, std::size_t> name_rows_;
  std::vector<std::string> names_;
  std::string end_ = "null", story_;
  // What the pages have.
  std::size_t told_ = 0, told_names_ = 0;
  std::string told_end_ = "null";
  // What is to be looked at.
  std::vector<ReportedStep> steps_;
  std::set<std::size_t> moved_;
  std::uint64_t lost_ = 0;
  bool is_due_ = false, is_looking_ = false, sees_all_ = false;
  bool is_over_ = false;  // the model cannot be asked any more
  Clock::time_point last_look_{};
  std::uint64_t next_ = 1;
  std::map<std::uint64_t, std::function<void(const Json&)>> asked_;
};

}  // namespace bip::live
