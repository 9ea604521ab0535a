// A debugging session as pages drive it: requests in, answers and notes out, as JSON texts. Knows no sockets.
//
// The run has one length for all pages; each page shows the position that it likes, and says in each request from which
// one (`at`) it goes on. Taking another step than the recorded one drops what is recorded after it, for all pages.
//
//   {"id": 1, "do": "take", "at": 3, "candidate": 0}        a candidate of the state after 3 moves
//   {"id": 2, "do": "walk", "at": 3, "count": 10}           steps that the policy chooses
//   {"id": 3, "do": "run", "at": 3, "until": "a@P"}         to a place to stop (compiler/docs/step.md), a breakpoint,
//   the end
//   {"id": 4, "do": "stop"}                                 ends a walk or a run
//   {"id": 5, "do": "delay", "at": 3, "time": "+20us"}
//   {"id": 6, "do": "post", "at": 3, "port": "panel.turn", "values": "3 true"}
//   {"id": 7, "do": "breakpoints", "texts": ["a@P"]}        replaces all
//   {"id": 8, "do": "watch", "at": 3, "texts": ["a.x + 1"]}
//   {"id": 9, "do": "why", "at": 3, "name": "a.p"}          an empty name: the deadlock
//   {"id": 10, "do": "later", "at": 3}                      what becomes a candidate when time passes
//   {"id": 11, "do": "save", "at": 3}                       a trace of the moves up to there
// Answer: {"id": 1, "ok": true, …} or {"id": 1, "ok": false, "error": text}. Notes, to all pages:
//   {"note": "run", "from": kept steps, "steps": […], "candidates": […], "names_from": n, "names": […], "end": …,
//    "by": page, "position": p, "halt": text}               as in view/run_record.hpp
//   {"note": "breakpoints", "texts": […]}
// A walk and a run are answered when they have ended.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "compiler/debug/debug_model.hpp"
#include "compiler/live/page_session.hpp"
#include "compiler/view/run_record.hpp"
#include "runtime/debug/session.hpp"

namespace bip::live {

class LiveSession final : public PageSession {
 public:
  using Json = nlohmann::ordered_json;
  static constexpr std::uint64_t kMostSteps = 100'000;
  static constexpr std::size_t kMostTexts = 100;

  /// The session is in its initial state; moves that it has ahead are shown by the pages, up to the last of which it
  /// goes. All must outlive this.
  LiveSession(const System& system, rt::DebugSession& session, const debug::DebugModel& model, std::uint64_t seed);

  /// The run without steps, for a page that is made (view/page.hpp).
  [[nodiscard]] const Json& initial() const { return initial_; }
  void greet(std::uint64_t page) override;
  [[nodiscard]] bool handle(std::uint64_t page, std::string_view message) override;
  [[nodiscard]] bool is_running() const override { return running_.has_value(); }
  void go_on() override;
  [[nodiscard]] bool is_interrupted() const override { return is_interrupted_; }
  void leave(std::uint64_t page) override;

 private:
  struct Request;
  static const std::vector<Request>& requests();
  /// A request of which more than its shape is sound.
  struct PageRequest {
    std::uint64_t page = 0, id = 0;
    const Json* body = nullptr;
  };
  struct Running {
    std::uint64_t page = 0, id = 0, left = 0;
    bool stops_at_breakpoints = false;
  };
  using Answer = std::optional<Json>;  // nothing: later

  Answer take(const PageRequest& asked);
  Answer walk(const PageRequest& asked);
  Answer run(const PageRequest& asked);
  Answer stop(const PageRequest& asked);
  Answer delay(const PageRequest& asked);
  Answer post(const PageRequest& asked);
  Answer set_breakpoints(const PageRequest& asked);
  Answer watch(const PageRequest& asked);
  Answer why(const PageRequest& asked);
  Answer later(const PageRequest& asked);
  Answer save(const PageRequest& asked);

  Answer moved(const PageRequest& asked, std::uint64_t at, rt::Halt halt);
  [[nodiscard]] Json refused();
  [[nodiscard]] std::string go_to(std::uint64_t position);
  void note_moves(std::uint64_t before);
  void note_move();
  void keep(std::uint64_t steps);
  void tell(std::uint64_t by, const std::string& halt);
  void finish(rt::Halt halt);
  [[nodiscard]] std::string halt_text(rt::Halt halt) const;
  [[nodiscard]] std::string run_note(std::size_t from, std::size_t to, std::size_t names_from, std::uint64_t by,
                                     const std::string& halt) const;
  [[nodiscard]] std::string breakpoints_note() const;

  rt::DebugSession& session_;
  const debug::DebugModel& model_;
  std::uint64_t seed_;
  view::RunRecorder recorder_;
  Json initial_;
  // Texts of JSON: a step takes a quarter of the memory so.
  std::vector<std::string> steps_, candidates_;  // candidates_: of the state after each step
  std::string end_ = "null";
  std::size_t told_ = 0, told_names_ = 0;  // steps and names that the pages have
  std::optional<Running> running_;
  bool is_interrupted_ = false;
  std::uint64_t next_breakpoint_ = 1;
};

}  // namespace bip::live
