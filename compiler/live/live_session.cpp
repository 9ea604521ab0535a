// See live_session.hpp.
#include "compiler/live/live_session.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/base/json_text.hpp"
#include "compiler/debug/event_values.hpp"
#include "compiler/system/system_ids.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/why_not.hpp"
#include "runtime/engine/interrupt.hpp"

namespace bip::live {

namespace {

using Json = LiveSession::Json;
// Moves between two looks at the sockets, and steps in a note.
constexpr std::uint64_t kMovesOfSlice = 500, kStepsOfNote = 5000;
constexpr std::size_t kDeepest = 8;

// The message as JSON: an object, not deeper than a request is. Nothing throws.
Json parse(std::string_view message) {
  std::size_t depth = 0;
  for (const char c : message) {
    if ((c == '{' || c == '[') && ++depth > kDeepest) return nullptr;
    if ((c == '}' || c == ']') && depth > 0) --depth;
  }
  return parse_json(message);
}

const Json* member(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}

}  // namespace

struct LiveSession::Request {
  enum class Field : std::uint8_t { No, Number, Text, Texts };
  const char* name;
  bool has_position;  // `at`
  const char* field;  // a second one; null: none
  Field kind;
  bool moves;
  Answer (LiveSession::*execute)(const PageRequest& asked);
};

const std::vector<LiveSession::Request>& LiveSession::requests() {
  using Field = Request::Field;
  static const std::vector<Request> kRequests = {
      {"take", true, "candidate", Field::Number, true, &LiveSession::take},
      {"walk", true, "count", Field::Number, true, &LiveSession::walk},
      {"run", true, "until", Field::Text, true, &LiveSession::run},
      {"stop", false, nullptr, Field::No, false, &LiveSession::stop},
      {"delay", true, "time", Field::Text, true, &LiveSession::delay},
      {"post", true, "port", Field::Text, true, &LiveSession::post},
      {"breakpoints", false, "texts", Field::Texts, true, &LiveSession::set_breakpoints},
      {"watch", true, "texts", Field::Texts, true, &LiveSession::watch},
      {"why", true, "name", Field::Text, true, &LiveSession::why},
      {"later", true, nullptr, Field::No, true, &LiveSession::later},
      {"save", true, nullptr, Field::No, true, &LiveSession::save},
  };
  return kRequests;
}

LiveSession::LiveSession(const System& system, rt::DebugSession& session, const debug::DebugModel& model,
                         std::uint64_t seed)
    : session_(session), model_(model), seed_(seed), recorder_(system, session) {
  session_.track(rt::Tracking::Every);
  const std::uint64_t length = session_.length();
  initial_ = recorder_.state();
  initial_["candidates"] = Json::array({recorder_.candidates()});
  initial_["steps"] = Json::array();
  while (session_.position() < length) {
    const std::uint64_t before = session_.position();
    if (session_.step() == rt::Halt::Refused || session_.position() == before) break;
    note_moves(before);
  }
  end_ = json_line(recorder_.end(session_.is_at_fault() ? rt::Halt::Fault : rt::Halt::Done, seed_));
  initial_["end"] = steps_.empty() ? parse_json(end_) : Json(nullptr);
  initial_["names"] = Json(recorder_.names());
  told_ = steps_.size();
  told_names_ = recorder_.names().size();
}

// -- What the pages have --

// Steps after the first `steps` have been dropped.
void LiveSession::keep(std::uint64_t steps) {
  BIP_ASSERT(steps <= steps_.size(), "{} of {} steps stay", steps, steps_.size());
  steps_.resize(steps);
  candidates_.resize(steps);
  told_ = std::min<std::size_t>(told_, steps);
}

// Records the moves that led from `before` to here, if they are new ones. A step that the policy chooses is several
// moves if events come before it: their states are visited again, where the session can go back.
void LiveSession::note_moves(std::uint64_t before) {
  const std::uint64_t end = session_.position();
  BIP_ASSERT(before <= steps_.size(), "a move begins at {} of {}", before, steps_.size());
  if (end == before || before < steps_.size()) return;
  // A fault that is no move would be gone.
  const bool can_return = end > before + 1 && session_.back_refusal().empty() && session_.last_move() != nullptr;
  if (can_return && session_.go_to(before) == rt::Halt::Done) {
    while (session_.position() == steps_.size() && session_.position() < end) {
      (void)session_.step();
      note_move();
    }
  } else {
    while (steps_.size() < end) note_move();
  }
  BIP_ASSERT(session_.position() == end && steps_.size() == end && candidates_.size() == end,
             "{} rows of {} moves, at {}", steps_.size(), end, session_.position());
}

// Records the move behind the last one that is recorded. Of one that did not lead to where the session is there is
// only a text.
void LiveSession::note_move() {
  const Json none{{"rows", Json::array()}, {"count", 0}};
  const rt::LastMove* const move = session_.position() == steps_.size() + 1 ? session_.last_move() : nullptr;
  if (move == nullptr) {
    steps_.push_back(
        json_line({-1, session_.move_text(steps_.size()), Json::array(), Json::array(), session_.core().now(), ""}));
    candidates_.push_back(json_line(none));
    return;
  }
  steps_.push_back(json_line(recorder_.step(*move)));
  candidates_.push_back(json_line(session_.is_at_fault() ? none : recorder_.candidates()));
}

std::string LiveSession::run_note(std::size_t from, std::size_t to, std::size_t names_from, std::uint64_t by,
                                  const std::string& halt) const {
  BIP_ASSERT(from <= to && to <= steps_.size() && steps_.size() == candidates_.size() &&
                 names_from <= recorder_.names().size(),
             "steps {} to {} of {}, names from {} of {}", from, to, steps_.size(), names_from,
             recorder_.names().size());
  std::string out = fmt::format("{{\"note\":\"run\",\"from\":{},\"steps\":[", from);
  for (std::size_t k = from; k < to; ++k) out += (k > from ? "," : "") + steps_[k];
  out += "],\"candidates\":[";
  for (std::size_t k = from; k < to; ++k) out += (k > from ? "," : "") + candidates_[k];
  Json names = Json::array();
  for (std::size_t k = names_from; k < recorder_.names().size(); ++k) names.push_back(recorder_.names()[k]);
  out += fmt::format("],\"names_from\":{},\"names\":{},\"end\":{},\"by\":{},\"position\":{},\"halt\":{}}}", names_from,
                     json_line(names), to == steps_.size() ? end_ : "null", by, session_.position(),
                     json_line(Json(halt)));
  return out;
}

void LiveSession::tell(std::uint64_t by, const std::string& halt) {
  send_to_all(run_note(told_, steps_.size(), told_names_, by, halt));
  told_ = steps_.size();
  told_names_ = recorder_.names().size();
}

std::string LiveSession::breakpoints_note() const {
  Json texts = Json::array();
  for (const rt::Breakpoint& b : session_.breakpoints())
    if (!b.is_temporary) texts.push_back(b.text);
  return json_line({{"note", "breakpoints"}, {"texts", texts}});
}

void LiveSession::greet(std::uint64_t page) {
  std::size_t at = 0;
  // The page is made with the names of the initial state; all others come with the first note.
  do {
    const std::size_t to = std::min<std::size_t>(at + kStepsOfNote, steps_.size());
    send(page, run_note(at, to, at == 0 ? 0 : recorder_.names().size(), 0, ""));
    at = to;
  } while (at < steps_.size());
  send(page, breakpoints_note());
}

void LiveSession::leave(std::uint64_t page) {
  if (running_ && running_->page == page) finish(rt::Halt::Interrupted);
}

// -- Requests --

bool LiveSession::handle(std::uint64_t page, std::string_view message) {
  const Json body = parse(message);
  if (!body.is_object()) return false;
  const Json* const id = member(body, "id");
  const Json* const verb = member(body, "do");
  if (id == nullptr || !id->is_number_unsigned() || verb == nullptr || !verb->is_string()) return false;
  const auto& rows = requests();
  const auto row = std::find_if(rows.begin(), rows.end(), [verb](const Request& r) { return *verb == r.name; });
  if (row == rows.end()) return false;
  const auto is_sound = [](const Json* value, Request::Field kind) {
    if (kind == Request::Field::No) return true;
    if (value == nullptr) return false;
    if (kind == Request::Field::Number) return value->is_number_unsigned();
    if (kind == Request::Field::Text) return value->is_string();
    return value->is_array() && value->size() <= kMostTexts &&
           std::all_of(value->begin(), value->end(), [](const Json& text) { return text.is_string(); });
  };
  if (row->has_position && !is_sound(member(body, "at"), Request::Field::Number)) return false;
  if (!is_sound(row->field == nullptr ? nullptr : member(body, row->field), row->kind)) return false;

  const PageRequest asked{page, id->get<std::uint64_t>(), &body};
  Answer answer;
  if (row->moves && running_) {
    answer = Json{{"error", "the model runs; `stop` ends that"}};
  } else {
    // Before anything is dropped.
    const std::string problem = row->has_position ? go_to(body["at"].get<std::uint64_t>()) : std::string();
    answer = problem.empty() ? (this->*row->execute)(asked) : Json{{"error", problem}};
  }
  if (!answer) return true;
  Json out{{"id", asked.id}, {"ok", !answer->contains("error")}};
  out.update(*answer);
  send(page, json_line(out));
  return true;
}

std::string LiveSession::go_to(std::uint64_t position) {
  if (position > steps_.size()) return fmt::format("the run has no position {}", position);
  if (position == session_.position()) return {};
  return session_.go_to(position) == rt::Halt::Refused ? "the session cannot go back: " + session_.problem()
                                                       : std::string();
}

Json LiveSession::refused() { return {{"error", session_.problem()}}; }

std::string LiveSession::halt_text(rt::Halt halt) const {
  switch (halt) {
    case rt::Halt::Breakpoint: {
      std::string out;
      for (const rt::u32 row : session_.reached()) {
        const rt::Breakpoint& b = session_.breakpoints()[row];
        out += std::string(out.empty() ? "" : ", ") + (b.is_temporary ? "reached " : "breakpoint ") + b.text;
      }
      return out;
    }
    case rt::Halt::Deadlock: return rt::end_story(session_.core(), session_.position(), seed_);
    case rt::Halt::Fault: return session_.fault();
    case rt::Halt::Interrupted: return "stopped";
    case rt::Halt::Limit: return fmt::format("a live page holds {} steps", kMostSteps);
    case rt::Halt::Done:
    case rt::Halt::Begin:
    case rt::Halt::Refused: break;
  }
  return {};
}

LiveSession::Answer LiveSession::take(const PageRequest& asked) {
  const std::uint64_t k = (*asked.body)["candidate"].get<std::uint64_t>(), at = session_.position();
  if (session_.is_at_fault()) return Json{{"error", "the run has ended with an error"}};
  if (k >= session_.core().candidate_count()) return Json{{"error", fmt::format("there is no candidate {}", k)}};
  if (at >= kMostSteps) return Json{{"error", halt_text(rt::Halt::Limit)}};
  if (session_.recorded_choice() != k) {
    session_.branch();
    keep(at);
  }
  const rt::Halt halt = session_.choose(k);
  note_moves(at);
  if (session_.position() == steps_.size()) end_ = json_line(recorder_.end(halt, seed_));
  tell(asked.page, halt_text(halt));
  return Json{{"position", session_.position()}};
}

LiveSession::Answer LiveSession::walk(const PageRequest& asked) {
  BIP_ASSERT(!running_, "page {} has a walk already", running_->page);
  const std::uint64_t count = (*asked.body)["count"].get<std::uint64_t>();
  session_.branch();
  keep(session_.position());
  running_ = Running{asked.page, asked.id, count, false};
  return std::nullopt;
}

LiveSession::Answer LiveSession::run(const PageRequest& asked) {
  const std::string until = (*asked.body)["until"].get<std::string>();
  if (!until.empty()) {
    Result<rt::Breakpoint> target = model_.parse_breakpoint(until);
    if (!target) return Json{{"error", fmt::format("`{}`: {}", until, target.error())}};
    target->is_temporary = true;
    session_.breakpoints().push_back(std::move(*target));
  }
  running_ = Running{asked.page, asked.id, ~std::uint64_t{0}, true};
  return std::nullopt;
}

void LiveSession::go_on() {
  if (!running_) return;
  rt::Halt halt = rt::Halt::Limit;
  for (std::uint64_t k = 0; k < kMovesOfSlice && halt == rt::Halt::Limit; ++k) {
    if (running_->left == 0) return finish(rt::Halt::Done);
    const std::uint64_t before = session_.position();
    if (before >= kMostSteps) return finish(rt::Halt::Limit);
    --running_->left;
    if (running_->stops_at_breakpoints) halt = session_.run(1);
    else if (const rt::Halt stepped = session_.step(); stepped != rt::Halt::Done) halt = stepped;
    note_moves(before);
  }
  if (halt == rt::Halt::Interrupted) is_interrupted_ = true;
  if (halt != rt::Halt::Limit) return finish(halt);
  end_ = "null";
  // A page is not flooded: the walk is seen to go on.
  tell(running_->page, "");
}

void LiveSession::finish(rt::Halt halt) {
  BIP_ASSERT(running_.has_value(), "nothing runs that ends by {}", halt);
  const Running done = *running_;
  running_.reset();
  const std::string text = halt_text(halt);
  if (session_.position() == steps_.size()) end_ = json_line(recorder_.end(halt, seed_));
  std::erase_if(session_.breakpoints(), [](const rt::Breakpoint& b) { return b.is_temporary; });
  tell(done.page, text);
  send(done.page, json_line({{"id", done.id}, {"ok", true}, {"position", session_.position()}, {"halt", text}}));
}

LiveSession::Answer LiveSession::stop(const PageRequest&) {
  if (running_) finish(rt::Halt::Interrupted);
  return Json::object();
}

// After a move from position `at`, which may have been refused.
LiveSession::Answer LiveSession::moved(const PageRequest& asked, std::uint64_t at, rt::Halt halt) {
  if (halt == rt::Halt::Refused) return refused();
  keep(at);
  note_moves(at);
  end_ = json_line(recorder_.end(halt, seed_));
  tell(asked.page, halt_text(halt));
  return Json{{"position", session_.position()}};
}

LiveSession::Answer LiveSession::delay(const PageRequest& asked) {
  const std::string text = (*asked.body)["time"].get<std::string>();
  const bool is_span = text.starts_with('+');
  const rt::i64 time = rt::parse_time(text.substr(is_span ? 1 : 0));
  if (time < 0) return Json{{"error", "an instant is `1s500ms`, a span `+20us`"}};
  const std::uint64_t at = session_.position();
  if (at >= kMostSteps) return Json{{"error", halt_text(rt::Halt::Limit)}};
  const rt::Halt halt = session_.delay(is_span ? session_.core().now() + time : time);
  return moved(asked, at, halt);
}

LiveSession::Answer LiveSession::post(const PageRequest& asked) {
  const Json* const values = member(*asked.body, "values");
  if (values != nullptr && !values->is_string()) return Json{{"error", "`values` is a text: `3 true`"}};
  const std::uint64_t at = session_.position();
  if (at >= kMostSteps) return Json{{"error", halt_text(rt::Halt::Limit)}};
  const rt::Halt halt = session_.post((*asked.body)["port"].get<std::string>(),
                                      debug::event_values(values == nullptr ? "" : values->get<std::string>()));
  return moved(asked, at, halt);
}

LiveSession::Answer LiveSession::set_breakpoints(const PageRequest& asked) {
  std::vector<rt::Breakpoint> made;
  Json problems = Json::array();
  for (const Json& text : (*asked.body)["texts"]) {
    Result<rt::Breakpoint> breakpoint = model_.parse_breakpoint(text.get<std::string>());
    problems.push_back(breakpoint ? "" : breakpoint.error());
    if (!breakpoint) continue;
    breakpoint->number = next_breakpoint_++;
    made.push_back(std::move(*breakpoint));
  }
  session_.breakpoints() = std::move(made);
  send_to_all(breakpoints_note());
  return Json{{"problems", problems}};
}

LiveSession::Answer LiveSession::watch(const PageRequest& asked) {
  Json values = Json::array();
  for (const Json& text : (*asked.body)["texts"]) {
    const Result<std::string> value = model_.evaluate(text.get<std::string>(), session_.core());
    values.push_back({value ? *value : value.error(), static_cast<bool>(value)});
  }
  return Json{{"values", values}};
}

LiveSession::Answer LiveSession::why(const PageRequest& asked) {
  const std::string name = (*asked.body)["name"].get<std::string>();
  rt::Core& core = session_.core();
  if (session_.is_at_fault()) return Json{{"text", session_.fault()}};
  if (name.empty()) {
    if (core.candidate_count() != 0) return Json{{"error", "this is no deadlock"}};
    return Json{{"text", rt::end_story(core, session_.position(), seed_)}};
  }
  const std::optional<debug::Named> named = model_.find(name);
  if (!named || (named->kind != debug::Named::Kind::Connector && named->kind != debug::Named::Kind::Port))
    return Json{{"error", fmt::format("there is no connector and no port `{}`", name)}};
  return Json{{"text", named->kind == debug::Named::Kind::Connector
                           ? rt::why_not_connector(core, named->owner)
                           : rt::why_not_port(core, named->owner, named->row)}};
}

LiveSession::Answer LiveSession::later(const PageRequest&) { return Json{{"later", recorder_.later()}}; }

LiveSession::Answer LiveSession::save(const PageRequest&) {
  std::string text;
  if (!session_.append_trace(text, rt::TraceFormat::Json)) return refused();
  return Json{{"trace", text}};
}

}  // namespace bip::live
