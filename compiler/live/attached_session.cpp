// See attached_session.hpp.
#include "compiler/live/attached_session.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <variant>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/base/json_text.hpp"
#include "compiler/debug/event_values.hpp"
#include "compiler/system/system_parts.hpp"
#include "compiler/system/uses_time.hpp"
#include "runtime/core/text.hpp"

namespace bip::live {

namespace {

using Json = AttachedSession::Json;
// Smaller models are looked at as a whole, so that what is shown is one state.
constexpr std::size_t kSmallModel = 64, kLongestAnswer = 10, kLongestRequest = 60'000, kDeepestMessage = 4;

const Json* found(const Json& object, const char* name) {
  if (!object.is_object()) return nullptr;
  const auto at = object.find(name);
  return at == object.end() ? nullptr : &*at;
}
std::uint64_t number_in(const Json& object, const char* name) {
  const Json* const value = found(object, name);
  return value != nullptr && value->is_number_integer() ? value->get<std::uint64_t>() : 0;
}
std::int64_t signed_in(const Json& object, const char* name) {
  const Json* const value = found(object, name);
  return value != nullptr && value->is_number_integer() ? value->get<std::int64_t>() : 0;
}
bool flag_in(const Json& object, const char* name) {
  const Json* const value = found(object, name);
  return value != nullptr && value->is_boolean() && value->get<bool>();
}
std::string text_in(const Json& object, const char* name) {
  const Json* const value = found(object, name);
  return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
}

// As the runtime writes it (rt::append_value).
std::string shown_value(const Json& value) {
  std::string out;
  if (value.is_boolean()) return value.get<bool>() ? "true" : "false";
  if (value.is_number_integer()) return std::to_string(value.get<std::int64_t>());
  if (value.is_number()) rt::append_double(out, value.get<double>());
  else if (value.is_string()) rt::append_quoted(out, value.get<std::string>().c_str());
  else out = "?";
  return out;
}

bool is_deep(std::string_view message) {
  std::size_t depth = 0;
  for (const char c : message) {
    if ((c == '{' || c == '[') && ++depth > kDeepestMessage) return true;
    if ((c == '}' || c == ']') && depth > 0) --depth;
  }
  return false;
}

// "cycle: phil[0] -> fork[1] -> phil[0]" of the story of a deadlock: each component once.
Json cycle_in(const std::string& story, const std::map<std::string, std::size_t>& atoms) {
  Json cycle = Json::array();
  const std::size_t begin = story.find("cycle: ");
  if (begin == std::string::npos) return cycle;
  std::string line = story.substr(begin + 7);
  line.erase(std::min(line.find('\n'), line.size()));
  std::vector<std::size_t> rows;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t end = std::min(line.find(" -> ", at), line.size());
    const auto atom = atoms.find(rt::whole_path(line.substr(at, end - at)));
    if (atom != atoms.end()) rows.push_back(atom->second);
    at = end + 4;
  }
  if (rows.size() > 1 && rows.front() == rows.back()) rows.pop_back();
  for (const std::size_t row : rows) cycle.push_back(row);
  return cycle;
}

}  // namespace

AttachedSession::AttachedSession(const System& system, std::unique_ptr<ModelConnection> connection)
    : system_(system), connection_(std::move(connection)) {
  for (std::size_t k = 0; k < system::atom_count(system); ++k) atoms_[system::atom_path(system, k)] = k;
  for (std::size_t k = 0; k < system::connector_count(system); ++k) connectors_[system::connector_path(system, k)] = k;
}

// -- The model's side --

// An answer; null: there was none. Notes that come before it are heard.
Json AttachedSession::ask_now(const Json& request) {
  if (!connection_->send(json_line(request))) return nullptr;
  while (const std::optional<std::string> line = connection_->wait_for_line(kLongestAnswer)) {
    Json answer = parse_json(*line);
    if (found(answer, "ok") != nullptr) return answer;
    hear_line(*line);
  }
  return nullptr;
}

std::string AttachedSession::begin() {
  if (system::atom_count(system_) > kMostAtoms)
    return fmt::format("a page shows no more than {} components of a served model, and this one has {}", kMostAtoms,
                       system::atom_count(system_));
  Json hello{{"do", "hello"}};
  if (!connection_->token().empty()) hello["token"] = connection_->token();
  const Json greeted = ask_now(hello);
  if (greeted.is_null()) return "no server answers there";
  if (!flag_in(greeted, "ok")) return text_in(greeted, "error");
  if (text_in(greeted, "format") != "bipc-serve" || number_in(greeted, "version") != 1)
    return "what answers there is no `bipc serve` of version 1";
  role_ = text_in(greeted, "role");
  if (!flag_in(ask_now({{"do", "subscribe"}}), "ok")) return "the model does not tell of its steps";
  const Json state = ask_now({{"do", "state"}});
  if (!flag_in(state, "ok")) return "the model does not say its state";
  if (const std::string other = read_state(state); !other.empty()) return other;
  // Steps that were told of before are in this state.
  steps_.clear();
  moved_.clear();
  row_time_ = signed_in(state, "time");
  first_ = Json{{"places", places_}, {"data", data_}, {"clocks", clocks_}, {"time", row_time_}};
  initial_ = first_;
  initial_["timed"] = system::is_timed(system_);
  initial_["clock_names"] = Json::array();
  for (const AtomType& type : system::atom_types(system_)) {
    Json names = Json::array();
    for (const bip::Clock& clock : type.clocks) names.push_back({clock.name, clock.unit});
    initial_["clock_names"].push_back(std::move(names));
  }
  initial_["candidates"] = Json::array({nullptr});
  initial_["steps"] = Json::array();
  initial_["names"] = Json::array();
  initial_["end"] = nullptr;
  note_model(state);
  is_due_ = sees_all_ = true;
  return {};
}

// The state of all components; or what makes this another model.
std::string AttachedSession::read_state(const Json& answer) {
  const Json* const atoms = found(answer, "atoms");
  if (atoms == nullptr || !atoms->is_object()) return "the model does not say its state";
  for (const auto& [path, state] : atoms->items())
    if (!atoms_.contains(path)) return fmt::format("another model runs there: it has a component `{}`", path);
  places_.assign(system::atom_count(system_), "");
  data_.assign(system::atom_count(system_), {});
  clocks_.assign(system::atom_count(system_), Json::array());
  for (std::size_t k = 0; k < system::atom_count(system_); ++k) {
    const std::string& path = system::atom_path(system_, k);
    const AtomType& type = system::type_of_atom(system_, k);
    const Json* const state = found(*atoms, path.c_str());
    if (state == nullptr) return fmt::format("another model runs there: it has no component `{}`", path);
    places_[k] = text_in(*state, "place");
    const std::string first = places_[k].substr(0, places_[k].find(','));
    if (std::find(type.places.begin(), type.places.end(), first) == type.places.end() && !first.empty())
      return fmt::format("another model runs there: `{}` is at `{}`", path, places_[k]);
    data_[k].assign(type.visible_variables(), "?");
    for (std::size_t clock = 0; clock < type.clocks.size(); ++clock) clocks_[k].push_back({0, 0, 1.0});
  }
  Json ignored = Json::array();
  (void)changes(*atoms, signed_in(answer, "time"), ignored);
  return {};
}

// Takes over what the answer says of components, and returns what is new; in `set_clocks` the clocks that were set, not
// after `until`: those of later steps are new in the next look.
Json AttachedSession::changes(const Json& atoms, std::int64_t until, Json& set_clocks) {
  BIP_ASSERT(places_.size() == atoms_.size() && data_.size() == atoms_.size() && clocks_.size() == atoms_.size(),
             "a state of {} of {} components", places_.size(), atoms_.size());
  Json out = Json::array();
  for (const auto& [path, state] : atoms.items()) {
    const auto atom = atoms_.find(path);
    if (atom == atoms_.end()) continue;
    const std::size_t k = atom->second;
    const AtomType& type = system::type_of_atom(system_, k);
    Json places(nullptr), values = Json::array();
    if (std::string now = text_in(state, "place"); now != places_[k]) places = places_[k] = std::move(now);
    const Json* const data = found(state, "data");
    for (std::size_t variable = 0; data != nullptr && variable < data_[k].size(); ++variable) {
      const Json* const value = found(*data, type.variables[variable].name.c_str());
      if (value == nullptr) continue;
      std::string now = shown_value(*value);
      if (now == data_[k][variable]) continue;
      data_[k][variable] = std::move(now);
      values.push_back({variable, data_[k][variable]});
    }
    if (!places.is_null() || !values.empty()) out.push_back({k, std::move(places), std::move(values)});
    const Json* const clocks = found(state, "clocks");
    for (std::size_t clock = 0; clocks != nullptr && clock < clocks_[k].size(); ++clock) {
      const Json* const shown = found(*clocks, type.clocks[clock].name.c_str());
      if (shown == nullptr) continue;
      const Json* const speed = found(*shown, "speed");
      Json now{signed_in(*shown, "set"), signed_in(*shown, "since"),
               speed != nullptr && speed->is_number() ? speed->get<double>() : 1.0};
      if (now == clocks_[k][clock] || now[1].get<std::int64_t>() > until) continue;
      set_clocks.push_back({k, clock, now[0], now[1], now[2]});
      clocks_[k][clock] = std::move(now);
    }
  }
  return out;
}

bool AttachedSession::ask(Json request, std::function<void(const Json&)> then) {
  request["id"] = next_;
  if (!connection_->send(json_line(request))) return false;
  asked_[next_++] = std::move(then);
  return true;
}

void AttachedSession::ask_or_end(Json request, std::function<void(const Json&)> then) {
  if (!ask(std::move(request), std::move(then))) is_over_ = true;
}

bool AttachedSession::hear() {
  std::vector<std::string> lines;
  const bool is_open = connection_->receive(lines);
  for (const std::string& line : lines) hear_line(line);
  return is_open && !is_over_;
}

void AttachedSession::hear_line(const std::string& line) {
  const Json message = parse_json(line);
  if (const std::string note = text_in(message, "note"); !note.empty()) {
    is_due_ = true;
    if (note == "step") return hear_step(message);
    if (note == "dropped") lost_ += number_in(message, "count");
    sees_all_ = true;
    if (note == "end") story_ = text_in(message, "text");
    if (note == "break" && send_to_all)
      send_to_all(json_line({{"note", "said"}, {"text", "paused after " + text_in(message, "interaction")}}));
    if (const std::string text = text_in(message, "text"); note != "end" && !text.empty() && send_to_all)
      send_to_all(json_line({{"note", "said"}, {"text", text}}));
    return;
  }
  const auto then = asked_.find(number_in(message, "id"));
  if (then == asked_.end()) return;
  const std::function<void(const Json&)> act = std::move(then->second);
  asked_.erase(then);
  act(message);
}

// The rows of the atom and of its port with this path; -1: there is none.
void AttachedSession::find_port(const std::string& port, std::int64_t& atom, std::int64_t& row) const {
  const std::size_t dot = port.rfind('.');
  const auto owner = dot == std::string::npos ? atoms_.end() : atoms_.find(port.substr(0, dot));
  atom = row = -1;
  if (owner == atoms_.end()) return;
  atom = static_cast<std::int64_t>(owner->second);
  const AtomType& type = system::type_of_atom(system_, owner->second);
  for (std::size_t k = 0; k < type.ports.size(); ++k)
    if (type.ports[k].name == port.substr(dot + 1)) row = static_cast<std::int64_t>(k);
}

void AttachedSession::hear_step(const Json& note) {
  ReportedStep told;
  told.number = number_in(note, "step");
  told.time = static_cast<std::int64_t>(number_in(note, "time"));
  told.text = text_in(note, "interaction");
  if (const auto connector = connectors_.find(told.text); connector != connectors_.end())
    told.connector = static_cast<std::int64_t>(connector->second);
  told.parts = Json::array();
  const Json* const ports = found(note, "ports");
  for (std::size_t k = 0; ports != nullptr && ports->is_array() && k < ports->size(); ++k) {
    if (!(*ports)[k].is_string()) continue;
    const std::string port = (*ports)[k].get<std::string>();
    std::int64_t atom = -1, row = -1;
    find_port(port, atom, row);
    told.text += (k == 0 ? "  " : " ") + port;
    if (atom < 0 || row < 0) continue;
    moved_.insert(static_cast<std::size_t>(atom));
    told.parts.push_back({atom, row, -1});
  }
  if (const Json* const values = found(note, "values"); values != nullptr) told.values = json_line(*values);
  // What a burst has had before is counted, not listed.
  if (steps_.size() > kMostStepsOfLook) {
    ++lost_;
    steps_.back() = std::move(told);
  } else {
    steps_.push_back(std::move(told));
  }
  is_due_ = true;
}

bool AttachedSession::tick() {
  const auto passed = Clock::now() - last_look_;
  if (!connection_->flush()) return false;
  const bool is_time =
      is_due_ ? passed >= std::chrono::milliseconds(1000 / kLooksPerSecond) : passed >= std::chrono::seconds(1);
  if (is_time && !is_looking_) look();
  return !is_over_;
}

// Asks for the components that have moved.
void AttachedSession::look() {
  BIP_ASSERT(!is_looking_, "{} requests wait, one of them for the state", asked_.size());
  is_looking_ = true;
  is_due_ = false;
  last_look_ = Clock::now();
  Json request{{"do", "state"}};
  if (system::atom_count(system_) > kSmallModel && !sees_all_) {
    Json paths = Json::array();
    for (const std::size_t atom : moved_) paths.push_back(system::atom_path(system_, atom));
    request["atoms"] = std::move(paths);
    if (json_line(request).size() > kLongestRequest) request.erase("atoms");
  }
  moved_.clear();
  sees_all_ = false;
  const std::size_t count = steps_.size();
  ask_or_end(std::move(request), [this, count](const Json& answer) {
    is_looking_ = false;
    if (!flag_in(answer, "ok") || found(answer, "atoms") == nullptr) return;
    // Steps that were told of meanwhile are those of the next look.
    BIP_ASSERT(count <= steps_.size(), "{} of {} steps are looked at", count, steps_.size());
    std::vector<ReportedStep> later(std::make_move_iterator(steps_.begin() + static_cast<std::ptrdiff_t>(count)),
                                    std::make_move_iterator(steps_.end()));
    steps_.resize(count);
    see(answer);
    steps_ = std::move(later);
  });
}

void AttachedSession::see(const Json& answer) {
  const std::uint64_t before = number_in(model_, "steps"), now = number_in(answer, "steps");
  const bool was_ended = flag_in(model_, "ended"), is_ended = flag_in(answer, "ended");
  const std::int64_t time = static_cast<std::int64_t>(number_in(answer, "time"));
  Json set_clocks = Json::array();
  // The answer may be later than the last step of the look, and a row shows no clock that was set after its instant.
  const bool is_gap = now < before || lost_ > 0;
  const std::int64_t row_time = is_gap ? time : steps_.empty() ? row_time_ : steps_.back().time;
  Json changed = changes(*found(answer, "atoms"), row_time, set_clocks);
  const bool is_still = flag_in(answer, "paused") || is_ended;
  const bool was_still = flag_in(model_, "paused") || was_ended;
  // With the clocks that were set since the last look.
  const auto last_row = [&](std::int64_t connector, const std::string& text, Json parts, const std::string& values) {
    row_time_ = row_time;
    add_row(
        json_line({connector, text, std::move(parts), std::move(changed), row_time, values, std::move(set_clocks)}));
  };
  if (now < before) {
    // Undone, or restored: others than those who moved are as they were.
    if (system::atom_count(system_) > kSmallModel) is_due_ = sees_all_ = true;
    last_row(-1, fmt::format("back to the state after {} steps", now), Json::array(), "");
    story_.clear();
  } else if (lost_ > 0) {
    last_row(-1, fmt::format("{} steps, the last one: {}", now - before, steps_.empty() ? "" : steps_.back().text),
             Json::array(), "");
  } else if (!steps_.empty()) {
    for (std::size_t k = 0; k + 1 < steps_.size(); ++k) {
      ReportedStep& step = steps_[k];
      row_time_ = step.time;
      add_row(json_line({step.connector, step.text, std::move(step.parts), Json::array(), step.time, step.values}));
    }
    ReportedStep& last = steps_.back();
    last_row(last.connector, last.text, std::move(last.parts), last.values);
  } else if (!changed.empty() || !set_clocks.empty()) {
    last_row(-1, "looked at again", Json::array(), "");
  }
  lost_ = 0;
  note_model(answer);
  end_ = !is_ended ? "null"
                   : json_line({{"story", story_.empty() ? std::string("The run has ended.") : story_},
                                {"cycle", cycle_in(story_, atoms_)}});
  const bool is_unknown = (rows_.empty() ? first_candidates_ : rows_.back().candidates) == "null";
  if (is_still && (is_unknown || !was_still || was_ended != is_ended)) {
    // Its candidates are those of this state, unless another client moves it meanwhile.
    ask_or_end({{"do", "candidates"}}, [this, now](const Json& given) {
      if (number_in(given, "steps") == now && number_in(model_, "steps") == now) see_candidates(given);
      else is_due_ = true;
    });
  }
  tell();
}

void AttachedSession::see_candidates(const Json& answer) {
  Json rows = Json::array();
  const Json* const given = found(answer, "candidates");
  for (std::size_t k = 0; given != nullptr && given->is_array() && k < given->size(); ++k) {
    std::string name = text_in((*given)[k], "interaction");
    const Json* const ports = found((*given)[k], "ports");
    for (std::size_t port = 0; ports != nullptr && ports->is_array() && port < ports->size(); ++port)
      if ((*ports)[port].is_string()) name += (port == 0 ? "  " : " ") + (*ports)[port].get<std::string>();
    rows.push_back(name_row(name));
  }
  const std::string text = json_line({{"rows", std::move(rows)}, {"count", number_in(answer, "count")}});
  if (rows_.empty()) {
    first_candidates_ = text;
    if (send_to_all) send_to_all(json_line(begin_note()));
  } else {
    rows_.back().candidates = text;
    told_ = std::min(told_, rows_.size() - 1);
  }
  tell();
}

std::size_t AttachedSession::name_row(const std::string& name) {
  const auto [at, is_new] = name_rows_.try_emplace(name, names_.size());
  if (is_new) names_.push_back(name);
  return at->second;
}

// -- What the pages have --

void AttachedSession::add_row(const std::string& step) {
  if (rows_.size() >= kMostRows) begin_again();
  rows_.push_back({step, "null"});
}

// The run is forgotten up to here; `places_` are those after the row that comes, which the page may know early.
void AttachedSession::begin_again() {
  rows_.clear();
  told_ = 0;
  first_ = Json{{"places", places_}, {"data", data_}, {"clocks", clocks_}, {"time", row_time_}};
  first_candidates_ = "null";
  if (send_to_all) send_to_all(json_line(begin_note()));
}

void AttachedSession::note_model(const Json& state) {
  Json now{{"note", "model"},
           {"paused", flag_in(state, "paused")},
           {"ended", flag_in(state, "ended")},
           {"time", number_in(state, "time")},
           {"steps", number_in(state, "steps")},
           {"late", number_in(state, "late")}};
  if (now == model_) return;
  model_ = std::move(now);
  if (send_to_all) send_to_all(json_line(model_));
}

Json AttachedSession::begin_note() const {
  Json note{{"note", "begin"}};
  note.update(first_);
  note["candidates"] = parse_json(first_candidates_);
  note["names"] = names_;
  return note;
}

std::string AttachedSession::run_note(std::size_t from, std::size_t to, std::size_t names_from) const {
  BIP_ASSERT(from <= to && to <= rows_.size() && names_from <= names_.size(),
             "rows {} to {} of {}, names from {} of {}", from, to, rows_.size(), names_from, names_.size());
  std::string out = fmt::format("{{\"note\":\"run\",\"from\":{},\"steps\":[", from);
  for (std::size_t k = from; k < to; ++k) out += (k > from ? "," : "") + rows_[k].step;
  out += "],\"candidates\":[";
  for (std::size_t k = from; k < to; ++k) out += (k > from ? "," : "") + rows_[k].candidates;
  Json names = Json::array();
  for (std::size_t k = names_from; k < names_.size(); ++k) names.push_back(names_[k]);
  out += fmt::format("],\"names_from\":{},\"names\":{},\"end\":{},\"by\":0,\"position\":{},\"halt\":\"\"}}", names_from,
                     json_line(names), to == rows_.size() ? end_ : "null", to);
  return out;
}

void AttachedSession::tell() {
  if (told_ == rows_.size() && told_names_ == names_.size() && told_end_ == end_) return;
  if (send_to_all) send_to_all(run_note(told_, rows_.size(), told_names_));
  told_ = rows_.size();
  told_names_ = names_.size();
  told_end_ = end_;
}

void AttachedSession::greet(std::uint64_t page) {
  constexpr std::size_t kRowsOfNote = 5000;
  send(page, json_line(begin_note()));
  // Names that begin_note() has had.
  const std::size_t names = names_.size();
  for (std::size_t at = 0; at < rows_.size();) {
    const std::size_t to = std::min(at + kRowsOfNote, rows_.size());
    send(page, run_note(at, to, names));
    at = to;
  }
  if (rows_.empty()) send(page, run_note(0, 0, names));
  send(page, json_line(model_));
}

void AttachedSession::leave(std::uint64_t) {}

// -- Requests --

bool AttachedSession::handle(std::uint64_t page, std::string_view message) {
  if (is_deep(message)) return false;
  const Json body = parse_json(message);
  const Json* const id = found(body, "id");
  if (id == nullptr || !id->is_number_unsigned()) return false;
  const std::string verb = text_in(body, "do");
  const auto has_number = [&body](const char* name) {
    const Json* const value = found(body, name);
    return value != nullptr && value->is_number_unsigned();
  };
  const auto has_text = [&body](const char* name) {
    const Json* const value = found(body, name);
    return value != nullptr && value->is_string();
  };
  Json request{{"do", verb}};
  std::string problem;
  if (verb == "pause" || verb == "resume") {
    // As they are.
  } else if (verb == "step" || verb == "back") {
    if (!has_number("count")) return false;
    request["count"] = body["count"];
  } else if (verb == "fire") {
    if (!has_number("candidate") || !has_number("steps")) return false;
    request["candidate"] = body["candidate"];
    request["steps"] = body["steps"];
  } else if (verb == "why") {
    if (!has_text("path")) return false;
    request["path"] = body["path"];
  } else if (verb == "break") {
    if (!has_text("path")) return false;
    const std::string path = body["path"].get<std::string>(), whole = rt::whole_path(path);
    std::int64_t atom = -1, row = -1;
    find_port(whole, atom, row);
    if (connectors_.contains(whole)) request["interactions"] = Json::array({whole});
    else if (row >= 0) request["ports"] = Json::array({whole});
    else if (!path.empty()) problem = fmt::format("there is no interaction and no port `{}`", path);
  } else if (verb == "post") {
    if (!has_text("port") || !has_text("values")) return false;
    request["port"] = body["port"];
    request["values"] = Json::array();
    for (const EventValue& value : debug::event_values(body["values"].get<std::string>()))
      std::visit([&request](const auto& v) { request["values"].push_back(v); }, value);
  } else {
    return false;
  }
  const std::uint64_t number = id->get<std::uint64_t>();
  const auto answer = [this, page, number](const Json& given) {
    Json out{{"id", number}, {"ok", flag_in(given, "ok")}};
    if (const std::string error = text_in(given, "error"); !error.empty()) out["error"] = error;
    if (const std::string why = text_in(given, "why"); !why.empty()) out["text"] = why;
    send(page, json_line(out));
  };
  if (!problem.empty()) {
    answer({{"ok", false}, {"error", problem}});
    return true;
  }
  const bool moves = verb != "why" && verb != "break";
  const bool is_sent = ask(std::move(request), [this, answer, moves](const Json& given) {
    answer(given);
    if (moves && flag_in(given, "ok") && !is_looking_) look();
    else if (moves) is_due_ = true;
  });
  if (!is_sent) answer({{"ok", false}, {"error", "the model does not read what it is asked"}});
  return true;
}

}  // namespace bip::live
