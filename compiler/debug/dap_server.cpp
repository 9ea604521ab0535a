// See dap_server.hpp.
#include "compiler/debug/dap_server.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bip/assert.hpp"
#include "bip/image_time.hpp"
#include "runtime/core/deadlock_explanation.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/text.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::debug {

namespace {

using nlohmann::json;

constexpr int kThread = 1;
// References of variables: the scopes, then a row for each component.
constexpr std::uint64_t kComponents = 1, kCandidates = 2, kChanges = 3, kFirstAtom = 1000;
constexpr std::uint64_t kMostRows = 1000;

const json* find_member(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}
std::string text_of(const json& object, const char* key) {
  const json* const found = find_member(object, key);
  return found != nullptr && found->is_string() ? found->get<std::string>() : std::string();
}
bool truth_of(const json& object, const char* key, bool without) {
  const json* const found = find_member(object, key);
  return found != nullptr && found->is_boolean() ? found->get<bool>() : without;
}
std::optional<std::uint64_t> number_of(const json& object, const char* key) {
  const json* const found = find_member(object, key);
  if (found == nullptr || !found->is_number_unsigned()) return std::nullopt;
  return found->get<std::uint64_t>();
}
const json& rows_of(const json& object, const char* key) {
  static const json kNone = json::array();
  const json* const found = find_member(object, key);
  return found != nullptr && found->is_array() ? *found : kNone;
}

std::string body_text(const json& message) { return message.dump(-1, ' ', false, json::error_handler_t::replace); }

std::string absolute_path(const std::string& path) {
  std::error_code error;
  const std::filesystem::path found = std::filesystem::weakly_canonical(path, error);
  return error ? path : found.string();
}

std::string without_end(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

}  // namespace

struct DapServer::Answer {
  json body = json::object();
  std::string problem;  // not empty: the request is refused
  // Sent after the response.
  std::function<void()> then;
};

struct DapServer::Request {
  const char* command;
  Answer (DapServer::*execute)(const json& arguments);
  bool needs_model;
};

const std::vector<DapServer::Request>& DapServer::requests() {
  static const std::vector<Request> kRequests = {
      {"initialize", &DapServer::initialize, false},
      {"launch", &DapServer::launch, false},
      {"setBreakpoints", &DapServer::set_breakpoints, true},
      {"setFunctionBreakpoints", &DapServer::set_function_breakpoints, true},
      {"dataBreakpointInfo", &DapServer::data_breakpoint_info, true},
      {"setDataBreakpoints", &DapServer::set_data_breakpoints, true},
      {"setExceptionBreakpoints", &DapServer::set_exception_breakpoints, true},
      {"configurationDone", &DapServer::configuration_done, true},
      {"threads", &DapServer::threads, true},
      {"stackTrace", &DapServer::stack_trace, true},
      {"scopes", &DapServer::scopes, true},
      {"variables", &DapServer::variables, true},
      {"setVariable", &DapServer::set_variable, true},
      {"evaluate", &DapServer::evaluate, true},
      {"next", &DapServer::step, true},
      {"stepIn", &DapServer::step, true},
      {"stepOut", &DapServer::step, true},
      {"stepInTargets", &DapServer::step_in_targets, true},
      {"stepBack", &DapServer::step_back, true},
      {"continue", &DapServer::go_on, true},
      {"reverseContinue", &DapServer::go_back, true},
      {"pause", &DapServer::pause, true},
      {"restart", &DapServer::restart, true},
      {"exceptionInfo", &DapServer::exception_info, true},
      {"completions", &DapServer::completions, true},
      {"disconnect", &DapServer::disconnect, false},
      {"terminate", &DapServer::disconnect, false},
  };
  return kRequests;
}

DapServer::DapServer(Launch launch, std::function<void(const std::string& body)> send)
    : launch_(std::move(launch)), send_(std::move(send)) {}
DapServer::~DapServer() = default;

// -- Messages --

void DapServer::send_event(const char* name, json body) {
  const json message = {{"seq", next_sequence_++}, {"type", "event"}, {"event", name}, {"body", std::move(body)}};
  send_(body_text(message));
}

void DapServer::send_output(const std::string& text, const char* category) {
  send_event("output", {{"category", category}, {"output", text}});
}

void DapServer::handle(std::string_view body) {
  const json message = json::parse(body, nullptr, false);
  const std::string command = text_of(message, "command");
  json response = {{"seq", next_sequence_++},
                   {"type", "response"},
                   {"request_seq", number_of(message, "seq").value_or(0)},
                   {"command", command},
                   {"success", false}};
  Answer answer;
  const auto request = std::find_if(requests().begin(), requests().end(),
                                    [&](const Request& known) { return command == known.command; });
  if (text_of(message, "type") != "request" || command.empty()) {
    answer.problem = "this is no request";
  } else if (request == requests().end()) {
    answer.problem = fmt::format("`{}` is not supported", command);
  } else if (request->needs_model && !is_launched()) {
    answer.problem = "no model was launched";
  } else {
    const json* const arguments = find_member(message, "arguments");
    answer = (this->*request->execute)(arguments == nullptr ? json::object() : *arguments);
  }
  if (answer.problem.empty()) {
    response["success"] = true;
    if (!answer.body.empty()) response["body"] = std::move(answer.body);
  } else {
    response["message"] = answer.problem;
  }
  send_(body_text(response));
  if (answer.then) answer.then();
}

// -- Begin and end --

DapServer::Answer DapServer::initialize(const json&) {
  json filters = json::array();
  filters.push_back({{"filter", "fault"}, {"label", "Run-time errors"}, {"default", true}});
  filters.push_back({{"filter", "deadlock"}, {"label", "Deadlocks"}, {"default", true}});
  filters.push_back({{"filter", "property"},
                     {"label", "Violated property"},
                     {"default", false},
                     {"supportsCondition", true},
                     {"conditionDescription", "never EXPR or always EXPR"}});
  json capabilities;
  for (const char* name :
       {"supportsConfigurationDoneRequest", "supportsFunctionBreakpoints", "supportsConditionalBreakpoints",
        "supportsHitConditionalBreakpoints", "supportsEvaluateForHovers", "supportsStepBack", "supportsSetVariable",
        "supportsRestartRequest", "supportsExceptionInfoRequest", "supportsExceptionFilterOptions", "supportsLogPoints",
        "supportsDataBreakpoints", "supportsStepInTargetsRequest", "supportsCompletionsRequest",
        "supportsTerminateRequest"}) {
    capabilities[name] = true;
  }
  capabilities["exceptionBreakpointFilters"] = std::move(filters);
  return {std::move(capabilities), {}, {}};
}

DapServer::Answer DapServer::launch(const json& arguments) {
  if (is_launched()) return {{}, "a model was launched already", {}};
  LaunchRequest wanted;
  wanted.program = text_of(arguments, "program");
  if (wanted.program.empty()) return {{}, "`program` is missing, the file of the model", {}};
  wanted.root = text_of(arguments, "root");
  if (const json& values = rows_of(arguments, "args"); !values.empty()) {
    std::string list;
    for (const json& value : values)
      list += (list.empty() ? "" : ", ") + (value.is_string() ? value.get<std::string>() : value.dump());
    wanted.root += "(" + list + ")";
  }
  wanted.trace = text_of(arguments, "trace");
  wanted.events = text_of(arguments, "events");
  wanted.policy = text_of(arguments, "policy");
  for (const json& folder : rows_of(arguments, "folders")) {
    if (folder.is_string()) wanted.folders.push_back(folder.get<std::string>());
  }
  wanted.seed = number_of(arguments, "seed").value_or(0);
  wanted.asap = truth_of(arguments, "asap", false);
  wanted.trusts_cpp = truth_of(arguments, "trustCpp", false);
  wanted.refuses_cpp = truth_of(arguments, "noCpp", false);
  stops_on_entry_ = truth_of(arguments, "stopOnEntry", true);
  launched_ = wanted;
  Result<std::unique_ptr<Debuggee>> made = launch_(wanted);
  if (!made) return {{}, without_end(made.error()), {}};
  debuggee_ = std::move(*made);
  begin_session();
  return {json::object(), {}, [this] { send_event("initialized", json::object()); }};
}

void DapServer::begin_session() {
  BIP_ASSERT(debuggee_->session != nullptr && debuggee_->model != nullptr, "a model without a session");
  files_.clear();
  for (const char* const file : model().image().files) files_.push_back(absolute_path(file));
  ConsoleOutput output;
  output.print = [this](std::string_view text) { console_text_ += text; };
  output.refuse = [this](const std::string& what, const std::string& help) {
    console_text_ += what + "\n" + (help.empty() ? "" : "  = help: " + help + "\n");
  };
  output.write = [](const std::string&, const std::string&) {
    return std::string("`bipc step` writes traces, the debug adapter writes no files");
  };
  output.number_breakpoint = [this] {
    owners_.push_back({Owner::Console, ""});
    return std::uint64_t{owners_.size()};
  };
  console_ = std::make_unique<Console>(session(), model(), launched_.seed, std::move(output));
  session().on_log = [this](const rt::Breakpoint& b) { send_output(b.message + "\n", "console"); };
  session().is_stopped = [this] { return has_input && has_input(); };
}

DapServer::Answer DapServer::configuration_done(const json&) {
  return {json::object(), {}, [this] {
            if (session().is_at_fault()) stop_after(rt::Halt::Fault, "entry");
            else if (stops_on_entry_ || session().position() != 0) send_stopped("entry", "");
            else running_ = Running::Forward;
          }};
}

DapServer::Answer DapServer::disconnect(const json&) {
  is_finished_ = true;
  running_ = Running::No;
  return {};
}

// The breakpoints stay.
DapServer::Answer DapServer::restart(const json&) {
  running_ = Running::No;
  last_halt_ = rt::Halt::Done;
  if (session().back_refusal().empty()) {
    (void)session().go_to(0);
  } else {
    std::vector<rt::Breakpoint> kept = session().breakpoints();
    Result<std::unique_ptr<Debuggee>> again = launch_(launched_);
    if (!again) return {{}, without_end(again.error()), {}};
    debuggee_ = std::move(*again);
    begin_session();
    // Conditions are about the other compilation's rows, which are the same.
    session().breakpoints() = std::move(kept);
  }
  return {json::object(), {}, [this] { send_stopped("entry", ""); }};
}

// -- Movement --

void DapServer::send_stopped(const std::string& reason, const std::string& text) {
  json body = {{"reason", reason}, {"threadId", kThread}, {"allThreadsStopped", true}};
  if (!text.empty()) body["text"] = text;
  if (last_halt_ == rt::Halt::Breakpoint) body["hitBreakpointIds"] = reached_numbers_;
  send_event("stopped", std::move(body));
}

void DapServer::stop_after(rt::Halt halt, const char* reason) {
  running_ = Running::No;
  last_halt_ = halt;
  switch (halt) {
    case rt::Halt::Breakpoint: return stop_at_breakpoint();
    case rt::Halt::Deadlock:
      if (rt::is_final_state(session().core())) return send_stopped("pause", "the run has ended in a final state");
      if (!stops_on_deadlock_) return send_event("terminated", json::object());
      return send_stopped("exception", "deadlock");
    case rt::Halt::Fault:
      if (!stops_on_fault_) return send_event("terminated", json::object());
      return send_stopped("exception", without_end(session().fault()));
    case rt::Halt::Begin: return send_stopped("entry", "");
    case rt::Halt::Interrupted: return send_stopped("pause", "");
    case rt::Halt::Done:
    case rt::Halt::Limit:
    case rt::Halt::Refused: break;
  }
  send_stopped(reason, "");
}

void DapServer::stop_at_breakpoint() {
  BIP_ASSERT(!session().reached().empty(), "the model stopped at no breakpoint, at {}", session().position());
  reached_numbers_.clear();
  for (const rt::u32 row : session().reached()) reached_numbers_.push_back(session().breakpoints()[row].number);
  const rt::Breakpoint& first = session().breakpoints()[session().reached().front()];
  reached_text_ = first.text;
  BIP_ASSERT(first.number != 0 && first.number <= owners_.size(), "breakpoint {} of {}", first.number, owners_.size());
  switch (owners_[first.number - 1].owner) {
    case Owner::Exception: return send_stopped("exception", "violated: " + first.text);
    case Owner::Function: return send_stopped("function breakpoint", first.text);
    case Owner::Data: return send_stopped("data breakpoint", first.text);
    case Owner::Source:
    case Owner::Console: return send_stopped("breakpoint", first.text);
  }
}

void DapServer::run() {
  BIP_ASSERT(is_launched() && is_running(), "nothing asks the model to run");
  const rt::Halt halt = running_ == Running::Forward ? session().run() : session().run_back();
  // A request has come: it is answered, and the model runs on unless it said otherwise.
  if (halt == rt::Halt::Interrupted && has_input && has_input()) return;
  stop_after(halt, "step");
}

DapServer::Answer DapServer::step(const json& arguments) {
  rt::Halt halt = rt::Halt::Done;
  if (const auto target = number_of(arguments, "targetId"))
    halt = session().choose(*target - std::min<std::uint64_t>(*target, 1));
  else halt = session().step();
  if (halt == rt::Halt::Refused) return {{}, session().problem(), {}};
  return {json::object(), {}, [this, halt] { stop_after(halt, "step"); }};
}

// Numbers from 1: some clients take 0 for none.
DapServer::Answer DapServer::step_in_targets(const json&) {
  json targets = json::array();
  rt::Core& core = session().core();
  for (std::uint64_t k = 0; !session().is_at_fault() && k < core.candidate_count() && k < kMostRows; ++k) {
    std::string name;
    rt::append_candidate(name, core, core.candidate(k));
    targets.push_back({{"id", k + 1}, {"label", rt::relative(name.c_str())}});
  }
  return {{{"targets", std::move(targets)}}, {}, {}};
}

DapServer::Answer DapServer::step_back(const json&) {
  const rt::Halt halt = session().back(1);
  if (halt == rt::Halt::Refused) return {{}, "B5041: " + session().problem(), {}};
  return {json::object(), {}, [this, halt] { stop_after(halt, "step"); }};
}

DapServer::Answer DapServer::go_on(const json&) {
  running_ = Running::Forward;
  return {{{"allThreadsContinued", true}}, {}, {}};
}

DapServer::Answer DapServer::go_back(const json&) {
  if (const std::string why = session().back_refusal(); !why.empty()) return {{}, "B5041: " + why, {}};
  running_ = Running::Back;
  return {};
}

DapServer::Answer DapServer::pause(const json&) {
  return {json::object(), {}, [this] { stop_after(rt::Halt::Interrupted, "pause"); }};
}

// -- Breakpoints --

std::uint32_t DapServer::file_of(const std::string& path) const {
  const std::string wanted = absolute_path(path);
  const auto found = std::find(files_.begin(), files_.end(), wanted);
  return found == files_.end() ? rt::kNone : static_cast<std::uint32_t>(found - files_.begin());
}

// Those that the same request set before go.
void DapServer::replace_breakpoints(Owner owner, const std::string& file) {
  std::erase_if(session().breakpoints(), [&](const rt::Breakpoint& b) {
    BIP_ASSERT(b.number != 0 && b.number <= owners_.size(), "breakpoint {} of {}", b.number, owners_.size());
    return owners_[b.number - 1].owner == owner && owners_[b.number - 1].file == file;
  });
}

json DapServer::add_breakpoint(Owner owner, const std::string& file, rt::Breakpoint made, const json& options) {
  if (const std::string condition = text_of(options, "condition"); !condition.empty() && owner != Owner::Exception) {
    Result<std::function<bool(const rt::Core&)>> parsed = model().parse_condition(condition);
    if (!parsed) return {{"verified", false}, {"message", parsed.error()}};
    made.condition = std::move(*parsed);
  }
  if (const std::string hits = text_of(options, "hitCondition"); !hits.empty()) {
    if (hits.size() > 9 || hits.find_first_not_of("0123456789") != std::string::npos)
      return {{"verified", false}, {"message", fmt::format("`{}` is not a number of hits", hits)}};
    const std::uint64_t count = std::stoull(hits);
    made.hits_before = count - std::min<std::uint64_t>(count, 1);
  }
  made.message = text_of(options, "logMessage");
  owners_.push_back({owner, file});
  made.number = owners_.size();
  json shown = {{"id", made.number}, {"verified", true}};
  if (made.kind == rt::BreakKind::Line) {
    shown["line"] = made.row;
    shown["source"] = source_of(made.owner);
  }
  session().breakpoints().push_back(std::move(made));
  return shown;
}

DapServer::Answer DapServer::set_breakpoints(const json& arguments) {
  const json* const source = find_member(arguments, "source");
  const std::string path = source == nullptr ? "" : text_of(*source, "path");
  if (path.empty()) return {{}, "`source` has no `path`", {}};
  replace_breakpoints(Owner::Source, path);
  json shown = json::array();
  const std::uint32_t file = file_of(path);
  for (const json& wanted : rows_of(arguments, "breakpoints")) {
    const std::uint64_t line = number_of(wanted, "line").value_or(0);
    const std::uint32_t found =
        file == rt::kNone || line > UINT32_MAX ? 0 : model().next_line(file, static_cast<std::uint32_t>(line));
    if (found == 0) {
      shown.push_back({{"verified", false}, {"message", "no transition with a port and no connector follows"}});
      continue;
    }
    rt::Breakpoint made;
    made.kind = rt::BreakKind::Line;
    made.owner = file;
    made.row = found;
    made.text = fmt::format("line {}", found);
    shown.push_back(add_breakpoint(Owner::Source, path, std::move(made), wanted));
  }
  return {{{"breakpoints", std::move(shown)}}, {}, {}};
}

DapServer::Answer DapServer::set_function_breakpoints(const json& arguments) {
  replace_breakpoints(Owner::Function, "");
  json shown = json::array();
  for (const json& wanted : rows_of(arguments, "breakpoints")) {
    Result<rt::Breakpoint> made = model().parse_breakpoint(text_of(wanted, "name"));
    if (made) shown.push_back(add_breakpoint(Owner::Function, "", std::move(*made), wanted));
    else shown.push_back({{"verified", false}, {"message", made.error()}});
  }
  return {{{"breakpoints", std::move(shown)}}, {}, {}};
}

DapServer::Answer DapServer::data_breakpoint_info(const json& arguments) {
  std::string name = text_of(arguments, "name");
  const std::uint64_t reference = number_of(arguments, "variablesReference").value_or(0);
  if (reference >= kFirstAtom && reference - kFirstAtom < model().image().atoms.size) {
    const std::string path = model().image().atoms[static_cast<rt::u32>(reference - kFirstAtom)].path();
    name = std::string(rt::relative(path.c_str())) + "." + name;
  }
  const std::optional<Named> named = model().find(name);
  if (!named || named->kind != Named::Kind::Data)
    return {{{"dataId", nullptr}, {"description", "only data of components can be watched"}}, {}, {}};
  return {{{"dataId", name}, {"description", name}, {"accessTypes", {"write"}}}, {}, {}};
}

DapServer::Answer DapServer::set_data_breakpoints(const json& arguments) {
  replace_breakpoints(Owner::Data, "");
  json shown = json::array();
  for (const json& wanted : rows_of(arguments, "breakpoints")) {
    const std::string name = text_of(wanted, "dataId");
    const std::optional<Named> named = model().find(name);
    if (!named || named->kind != Named::Kind::Data) {
      shown.push_back({{"verified", false}, {"message", fmt::format("there is no data `{}`", name)}});
      continue;
    }
    rt::Breakpoint made;
    made.kind = rt::BreakKind::Data;
    made.owner = named->owner;
    made.row = named->row;
    made.text = name;
    shown.push_back(add_breakpoint(Owner::Data, "", std::move(made), wanted));
  }
  return {{{"breakpoints", std::move(shown)}}, {}, {}};
}

DapServer::Answer DapServer::set_exception_breakpoints(const json& arguments) {
  replace_breakpoints(Owner::Exception, "");
  stops_on_fault_ = stops_on_deadlock_ = false;
  for (const json& filter : rows_of(arguments, "filters")) {
    stops_on_fault_ |= filter == "fault";
    stops_on_deadlock_ |= filter == "deadlock";
  }
  json shown = json::array();
  for (std::size_t k = 0; k < rows_of(arguments, "filters").size(); ++k) shown.push_back({{"verified", true}});
  for (const json& option : rows_of(arguments, "filterOptions")) {
    const std::string filter = text_of(option, "filterId"), condition = text_of(option, "condition");
    stops_on_fault_ |= filter == "fault";
    stops_on_deadlock_ |= filter == "deadlock";
    if (filter != "property") {
      shown.push_back({{"verified", true}});
      continue;
    }
    Result<std::function<bool(const rt::Core&)>> parsed = model().parse_condition(condition);
    if (!parsed) {
      shown.push_back({{"verified", false}, {"message", parsed.error()}});
      continue;
    }
    rt::Breakpoint made;
    made.condition = std::move(*parsed);
    made.text = condition;
    shown.push_back(add_breakpoint(Owner::Exception, "", std::move(made), option));
  }
  return {{{"breakpoints", std::move(shown)}}, {}, {}};
}

DapServer::Answer DapServer::exception_info(const json&) {
  json body = {{"breakMode", "always"}};
  if (session().is_at_fault()) {
    body["exceptionId"] = "fault";
    body["description"] = without_end(session().fault());
  } else if (last_halt_ == rt::Halt::Deadlock) {
    body["exceptionId"] = "deadlock";
    body["description"] = without_end(rt::deadlock_story(session().core(), session().position(), launched_.seed));
  } else if (last_halt_ == rt::Halt::Breakpoint) {
    body["exceptionId"] = "property";
    body["description"] = reached_text_;
  } else {
    return {{}, "the model has not stopped at an exception", {}};
  }
  return {std::move(body), {}, {}};
}

// -- Looking --

DapServer::Answer DapServer::threads(const json&) {
  return {{{"threads", {{{"id", kThread}, {"name", model().image().name}}}}}, {}, {}};
}

json DapServer::source_of(std::uint32_t file) const {
  BIP_ASSERT(file < files_.size(), "file {} of {}", file, files_.size());
  return {{"name", std::filesystem::path(files_[file]).filename().string()}, {"path", files_[file]}};
}

json DapServer::frame(int id, const std::string& name, rt::SourceLine loc) const {
  json shown = {
      {"id", id}, {"name", name}, {"line", loc.line}, {"column", loc.line == 0 ? 0 : std::max(loc.column, 1u)}};
  if (loc.line != 0 && loc.file < files_.size()) shown["source"] = source_of(loc.file);
  return shown;
}

DapServer::Answer DapServer::stack_trace(const json&) {
  json frames = json::array();
  const rt::LastMove* const last = session().last_move();
  if (last == nullptr) {
    frames.push_back(frame(1, session().position() == 0 ? "initial state" : "state", {}));
  } else {
    frames.push_back(frame(1, last->text, last->loc.line != 0 || last->parts.empty() ? last->loc : last->parts[0].loc));
    for (const rt::MovePart& part : last->parts) {
      const std::string path = model().image().atoms[part.atom].path();
      const rt::AtomType& type = session().core().tables().atom_type(part.atom);
      frames.push_back(frame(static_cast<int>(frames.size()) + 1,
                             std::string(rt::relative(path.c_str())) + "." + type.ports[part.port].name, part.loc));
    }
  }
  const std::size_t count = frames.size();
  return {{{"stackFrames", std::move(frames)}, {"totalFrames", count}}, {}, {}};
}

DapServer::Answer DapServer::scopes(const json& arguments) {
  json shown = json::array();
  const std::uint64_t id = number_of(arguments, "frameId").value_or(1);
  const rt::LastMove* const last = session().last_move();
  if (last != nullptr && id >= 2 && id - 2 < last->parts.size()) {
    const rt::u32 atom = last->parts[id - 2].atom;
    const std::string path = model().image().atoms[atom].path();
    shown.push_back(
        {{"name", rt::relative(path.c_str())}, {"variablesReference", kFirstAtom + atom}, {"expensive", false}});
  }
  shown.push_back({{"name", "Components"}, {"variablesReference", kComponents}, {"expensive", false}});
  shown.push_back({{"name", "Candidates"}, {"variablesReference", kCandidates}, {"expensive", false}});
  shown.push_back({{"name", "Changes"}, {"variablesReference", kChanges}, {"expensive", false}});
  return {{{"scopes", std::move(shown)}}, {}, {}};
}

void DapServer::append_atom(json& rows, std::uint32_t atom) const {
  const rt::Core& core = debuggee_->session->core();
  const rt::AtomType& type = core.tables().atom_type(atom);
  const rt::VariableId first = core.image().atoms[atom].variable(0);
  const auto append = [&rows](const std::string& name, const std::string& value) {
    rows.push_back({{"name", name}, {"value", value}, {"variablesReference", 0}});
  };
  append("place", rt::places_of(core, atom));
  const rt::u32 clocks = type.time == nullptr ? 0 : type.time->clocks.size;
  const rt::u32 count = rt::visible_variables(type);
  for (rt::u32 k = 0; k < count; ++k) {
    std::string value;
    rt::append_value(value, core.image(), type.variables[k].type, core.cell(first + k));
    append(type.variables[k].name, value);
  }
  for (rt::u32 k = 0; k < clocks; ++k) {
    std::string value;
    rt::append_time(value, static_cast<rt::i64>(core.time().clock_value(atom, k)));
    append(type.time->clocks[k].name, value);
  }
}

DapServer::Answer DapServer::variables(const json& arguments) {
  const std::uint64_t reference = number_of(arguments, "variablesReference").value_or(0);
  const std::uint64_t start = number_of(arguments, "start").value_or(0);
  const std::uint64_t count = std::min(number_of(arguments, "count").value_or(kMostRows), kMostRows);
  rt::Core& core = session().core();
  json rows = json::array();
  if (reference == kComponents) {
    for (std::uint64_t atom = start; atom < core.image().atoms.size && rows.size() < count; ++atom) {
      const auto row = static_cast<rt::u32>(atom);
      const std::string path = core.image().atoms[row].path();
      const std::string data = rt::data_of(core, row);
      rows.push_back({{"name", rt::relative(path.c_str())},
                      {"value", rt::places_of(core, row) + (data.empty() ? "" : "  " + data)},
                      {"variablesReference", kFirstAtom + atom}});
    }
  } else if (reference == kCandidates) {
    for (std::uint64_t k = start; !session().is_at_fault() && k < core.candidate_count() && rows.size() < count; ++k) {
      std::string name;
      rt::append_candidate(name, core, core.candidate(k));
      rows.push_back(
          {{"name", fmt::format("[{}]", k)}, {"value", rt::relative(name.c_str())}, {"variablesReference", 0}});
    }
  } else if (reference == kChanges) {
    const rt::LastMove* const last = session().last_move();
    for (std::size_t k = 0; last != nullptr && k < last->changes.size(); ++k) {
      const rt::AtomChange& change = last->changes[k];
      const std::string path = core.image().atoms[change.atom].path();
      std::string before = change.places;
      for (std::size_t v = 0; v < change.variables.size(); ++v) {
        before +=
            fmt::format("{}{} = {}", before.empty() ? "" : "  ",
                        core.tables().atom_type(change.atom).variables[change.variables[v]].name, change.values[v]);
      }
      rows.push_back({{"name", rt::relative(path.c_str())},
                      {"value", "was " + before},
                      {"variablesReference", kFirstAtom + change.atom}});
    }
  } else if (reference >= kFirstAtom && reference - kFirstAtom < core.image().atoms.size) {
    append_atom(rows, static_cast<std::uint32_t>(reference - kFirstAtom));
  } else {
    return {{}, "there are no such variables", {}};
  }
  return {{{"variables", std::move(rows)}}, {}, {}};
}

DapServer::Answer DapServer::set_variable(const json& arguments) {
  const std::uint64_t reference = number_of(arguments, "variablesReference").value_or(0);
  if (reference < kFirstAtom || reference - kFirstAtom >= model().image().atoms.size)
    return {{}, "only data of components can be set", {}};
  const auto atom = static_cast<rt::u32>(reference - kFirstAtom);
  const std::string path = model().image().atoms[atom].path(), name = text_of(arguments, "name");
  const std::optional<Named> named = model().find(path + "." + name);
  if (!named || named->kind != Named::Kind::Data) return {{}, fmt::format("there is no data `{}`", name), {}};
  const rt::Var& variable = session().core().tables().atom_type(atom).variables[named->row];
  const Result<rt::Cell> value = model().parse_value(text_of(arguments, "value"), variable.type);
  if (!value) return {{}, value.error(), {}};
  const rt::Halt halt = session().assign(atom, named->row, *value);
  if (halt == rt::Halt::Refused) return {{}, session().problem(), {}};
  if (halt == rt::Halt::Fault) return {{}, without_end(session().fault()), [this] { stop_after(rt::Halt::Fault, ""); }};
  std::string shown;
  rt::append_value(shown, model().image(), variable.type,
                   session().core().cell(model().image().atoms[atom].variable(named->row)));
  return {{{"value", shown}}, {}, {}};
}

// In the debug console a command of `bipc step`; elsewhere an expression.
DapServer::Answer DapServer::evaluate(const json& arguments) {
  const std::string expression = text_of(arguments, "expression");
  if (text_of(arguments, "context") != "repl") {
    const Result<std::string> value = model().evaluate(expression, session().core());
    if (!value) return {{}, value.error(), {}};
    return {{{"result", *value}, {"variablesReference", 0}}, {}, {}};
  }
  const std::uint64_t before = session().position(), length = session().length();
  console_text_.clear();
  // A run without end would answer nothing else: it is `continue`.
  if (expression.starts_with('r') || expression.starts_with('R'))
    return {{}, "`continue` and `reverseContinue` run the model; breakpoints say where it stops", {}};
  (void)console_->execute(expression);
  const bool has_moved = before != session().position() || length != session().length();
  std::function<void()> then;
  if (has_moved) then = [this] { stop_after(session().is_at_fault() ? rt::Halt::Fault : rt::Halt::Done, "goto"); };
  return {{{"result", without_end(console_text_)}, {"variablesReference", 0}}, {}, std::move(then)};
}

DapServer::Answer DapServer::completions(const json& arguments) {
  const std::string text = text_of(arguments, "text");
  const std::size_t begin = text.find_last_of(" \t(!&|<>=+-*");
  const std::string word = begin == std::string::npos ? text : text.substr(begin + 1);
  constexpr std::size_t kMostOffered = 100;
  json targets = json::array();
  for (const std::string& found : model().complete(word, kMostOffered)) {
    targets.push_back(
        {{"label", found}, {"start", begin == std::string::npos ? 0 : begin + 1}, {"length", word.size()}});
  }
  return {{{"targets", std::move(targets)}}, {}, {}};
}

}  // namespace bip::debug
