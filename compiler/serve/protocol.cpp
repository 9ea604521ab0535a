// See protocol.hpp.
#include "compiler/serve/protocol.hpp"

#include <nlohmann/json.hpp>
#include <optional>
#include <variant>

#include "bip/image_time.hpp"
#include "compiler/serve/check_line.hpp"
#include "runtime/core/text.hpp"

namespace bip::serve {

namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t kMaxAtoms = 1000, kMaxCandidates = 1000;

// Text from a model or a client may be no UTF-8.
std::string line_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

Json answer_to(const Json& id) {
  Json answer;
  if (!id.is_null()) answer["id"] = id;
  answer["ok"] = true;
  return answer;
}
std::string refusal_of(const Json& id, const std::string& what) {
  Json answer;
  if (!id.is_null()) answer["id"] = id;
  answer["ok"] = false;
  answer["error"] = what;
  return line_of(answer);
}

const char* type_name(rt::CellType type) {
  switch (type) {
    case rt::CellType::Int: return "int";
    case rt::CellType::Bool: return "bool";
    case rt::CellType::Float: return "float";
    case rt::CellType::String: return "string";
  }
  return "object";
}

std::string path_of(const rt::Atom& atom, const rt::Port& port) { return atom.path() + "." + port.name; }

Json ports_of(Controller& controller) {
  const rt::Image& image = controller.image();
  Json ports = Json::array();
  for (const rt::Atom& atom : image.atoms) {
    const rt::AtomType& type = image.atom_types[atom.type];
    for (std::uint32_t k = 0; type.time != nullptr && k < type.time->events.size; ++k) {
      const rt::Port& port = type.ports[type.time->events[k].port];
      Json vars = Json::object();
      for (const rt::Var& v : image.port_types[port.type].vars) vars[v.name] = type_name(v.type);
      if (controller.requests().is_mailbox_port(path_of(atom, port))) continue;
      ports.push_back({{"port", path_of(atom, port)}, {"values", std::move(vars)}});
      if (ports.size() == kMaxAtoms) return ports;
    }
  }
  return ports;
}

Json services_of(const Requests& requests) {
  Json all = Json::array();
  for (const ServiceText& s : requests.services()) {
    Json values = Json::object();
    for (const ParameterText& p : s.parameters) values[std::string(p.name)] = p.is_word ? "word" : "number";
    all.push_back({{"service", s.name},
                   {"kind", s.is_control ? "control" : "activity"},
                   {"overtakes", s.overtakes},
                   {"values", std::move(values)}});
  }
  return all;
}

// The value, or an empty text for what no event carries.
bool value_of(const Json& json, rt::CellType type, EventValue& out, std::string& wrong) {
  if (json.is_boolean()) out = json.get<bool>();
  else if (json.is_string()) out = json.get<std::string>();
  else if (json.is_number() && type == rt::CellType::Float) out = json.get<double>();
  else if (json.is_number_integer() && json >= INT32_MIN && json <= INT32_MAX) out = json.get<std::int32_t>();
  else wrong = "a value is an int of 32 bits, a float, a string, true or false";
  return wrong.empty();
}

const rt::PortType* type_of_port(const rt::Image& image, const std::string& port) {
  const std::string wanted = rt::whole_path(port);
  for (const rt::Atom& atom : image.atoms) {
    if (!wanted.starts_with(atom.path())) continue;
    const rt::AtomType& type = image.atom_types[atom.type];
    for (const rt::Port& p : type.ports) {
      if (path_of(atom, p) == wanted) return &image.port_types[p.type];
    }
  }
  return nullptr;
}

// Empty, or what is wrong.
std::string post(Controller& controller, const Json& request) {
  const auto port = request.find("port");
  if (port == request.end() || !port->is_string()) return "`port` is missing, the path of a port for events";
  const std::string path = port->get<std::string>();
  if (controller.requests().is_mailbox_port(path))
    return "`" + path + "` takes no events: a request is {\"do\":\"request\",\"service\":…}";
  const std::uint32_t row = controller.events().event_port(path);
  if (row == rt::kNone) return "there is no port `" + path + "` for events from outside";
  const rt::Span<rt::Var>& vars = type_of_port(controller.image(), path)->vars;
  std::vector<EventValue> values(vars.size);
  std::string wrong;
  const Json given = request.value("values", Json::array());
  if (given.size() != vars.size || !(given.is_array() || given.is_object()))
    return "`" + path + "` takes " + std::to_string(vars.size) + " values";
  for (std::uint32_t k = 0; k < vars.size && wrong.empty(); ++k) {
    if (given.is_object() && !given.contains(vars[k].name)) return std::string("`") + vars[k].name + "` is missing";
    (void)value_of(given.is_object() ? given[vars[k].name] : given[k], vars[k].type, values[k], wrong);
  }
  if (!wrong.empty()) return wrong;
  switch (controller.events().post(row, std::move(values))) {
    case Posted::Taken: break;
    case Posted::Full: return "full: too many events wait for the port";
    case Posted::NoSuchPort:
    case Posted::BadValues: return "the values are not of the types of the port";
  }
  return {};
}

// Of these atoms, or (nullopt) of the first kMaxAtoms. Returns an empty text, or what is wrong.
std::string state_of(const Controller& controller, const std::optional<std::set<std::string>>& names, Json& atoms) {
  if (names && names->empty()) return {};
  const rt::Image& image = controller.image();
  const Execution& system = controller.system();
  std::set<std::string> wanted;
  if (names) {
    for (const std::string& name : *names) {
      wanted.insert(rt::whole_path(name));
      if (system.place(rt::whole_path(name)).empty()) return "there is no atom `" + name + "`";
    }
  }
  for (const rt::Atom& atom : image.atoms) {
    if (names && !wanted.contains(atom.path())) continue;
    if (atoms.size() == kMaxAtoms) break;
    const rt::AtomType& type = image.atom_types[atom.type];
    const std::uint32_t hidden = rt::visible_variables(type);
    Json data = Json::object();
    for (std::uint32_t k = 0; k < hidden; ++k) {
      const std::string path = atom.path() + "." + type.variables[k].name;
      std::int32_t whole = 0;
      bool truth = false;
      double real = 0;
      std::string text;
      if (system.read(path, whole)) data[type.variables[k].name] = whole;
      else if (system.read(path, truth)) data[type.variables[k].name] = truth;
      else if (system.read(path, real)) data[type.variables[k].name] = real;
      else if (system.read(path, text)) data[type.variables[k].name] = text;
    }
    Json& row = atoms[atom.path()] = {{"place", system.place(atom.path())}, {"data", std::move(data)}};
    const std::vector<Execution::ClockReading> clocks = system.clocks(atom.path());
    if (!clocks.empty()) row["clocks"] = Json::object();
    for (const Execution::ClockReading& clock : clocks) {
      const double passed = static_cast<double>(system.now() - clock.since) * clock.speed;
      row["clocks"][clock.name] = {
          {"value", (static_cast<double>(clock.value) + passed) / static_cast<double>(clock.unit)},
          {"set", clock.value},
          {"since", clock.since},
          {"speed", clock.speed}};
    }
  }
  return {};
}

Json candidates_of(const Execution& system) {
  const std::uint64_t count = std::min<std::uint64_t>(system.candidate_count(), kMaxCandidates);
  Json list = Json::array();
  for (std::uint64_t k = 0; k < count; ++k)
    list.push_back({{"candidate", k}, {"interaction", system.candidate(k)}, {"ports", system.candidate_ports(k)}});
  return list;
}

// Empty, or what is wrong.
std::string poster_of(const Requests& requests, const std::string& poster, Json& answer) {
  if (requests.poster_value == nullptr)
    return "the model's C++ has no function `extern \"C\" const char* bip_poster_value(const char* poster)`";
  const char* const text = requests.poster_value(poster.c_str());
  if (text == nullptr) return "there is no poster `" + poster + "` that shows its value";
  answer["value"] = *text == '\0' ? Json() : Json::parse(text, nullptr, false);
  return answer["value"].is_discarded() ? "what poster `" + poster + "` holds is no JSON" : "";
}

// A set of strings; false if it is something else.
bool texts_of(const Json& request, const char* key, std::set<std::string>& out) {
  const auto list = request.find(key);
  if (list == request.end()) return true;
  if (!list->is_array()) return false;
  for (const Json& item : *list) {
    if (!item.is_string()) return false;
    out.insert(item.get<std::string>());
  }
  return true;
}

bool count_of(const Json& request, const char* key, std::uint64_t without, std::uint64_t& out) {
  const auto count = request.find(key);
  out = without;
  if (count == request.end()) return true;
  if (!count->is_number_unsigned()) return false;
  out = count->get<std::uint64_t>();
  return true;
}

// No request is as deep as this; what is copied and written level by level must not come at the end of the stack.
constexpr int kMaxDepth = 16;
bool is_too_deep(const std::string& line) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (in_text && line[k] == '\\') ++k;
    else if (line[k] == '"') in_text = !in_text;
    else if (!in_text && (line[k] == '[' || line[k] == '{') && ++depth > kMaxDepth) return true;
    else if (!in_text && (line[k] == ']' || line[k] == '}')) --depth;
  }
  return false;
}

// What is done between two steps, and answered then.
void ask(Controller& controller, const Reply& reply, const Json& id,
         std::function<std::string(Controller&, Json&)> work) {
  controller.ask([send = reply.send, id, work = std::move(work)](Controller& c) {
    Json answer = answer_to(id);
    const std::string wrong = work(c, answer);
    send(wrong.empty() ? line_of(answer) : refusal_of(id, wrong));
  });
}

struct RequestKind {
  std::string_view name;
  Role role;  // who may do it
};
constexpr RequestKind kRequests[] = {
    {"hello", Role::Observer},    {"subscribe", Role::Observer},  {"unsubscribe", Role::Observer},
    {"state", Role::Observer},    {"candidates", Role::Observer}, {"why", Role::Observer},
    {"requests", Role::Observer}, {"poster", Role::Observer},     {"post", Role::Requester},
    {"codels", Role::Observer},   {"request", Role::Requester},   {"cancel", Role::Requester},
    {"break", Role::Operator},    {"pause", Role::Operator},      {"resume", Role::Operator},
    {"step", Role::Operator},     {"fire", Role::Operator},       {"back", Role::Operator},
    {"snapshot", Role::Operator}, {"restore", Role::Operator},    {"shutdown", Role::Operator},
};

std::string with_article(Role role) { return std::string(role == Role::Requester ? "a " : "an ") + role_name(role); }

// The role that a `hello` asks for; empty, or what is wrong.
std::string role_of(const Json& request, Role& role) {
  const auto wanted = request.find("role");
  if (wanted == request.end()) return {};
  for (const Role each : {Role::Observer, Role::Requester, Role::Operator}) {
    if (*wanted != role_name(each)) continue;
    if (each > role) return "this client is no more than " + with_article(role);
    role = each;
    return {};
  }
  return "`role` is \"observer\", \"requester\" or \"operator\"";
}

}  // namespace

LineKind kind_of_line(const std::string& line) {
  return is_too_deep(line) || check_line(line).is_object ? LineKind::Object : LineKind::NoObject;
}

const char* role_name(Role role) {
  return role == Role::Observer ? "observer" : role == Role::Requester ? "requester" : "operator";
}

bool is_asking(const std::string& line) {
  if (is_too_deep(line)) return false;
  const Json request = Json::parse(line, nullptr, false);
  if (!request.is_object()) return false;
  const auto what = request.find("do");
  return what != request.end() && (*what == "post" || *what == "request");
}

std::string token_of_hello(const std::string& line) {
  if (is_too_deep(line)) return {};
  const Json request = Json::parse(line, nullptr, false);
  if (!request.is_object()) return {};
  const auto what = request.find("do"), token = request.find("token");
  if (what == request.end() || *what != "hello" || token == request.end() || !token->is_string()) return {};
  return token->get<std::string>();
}

void handle_line(Controller& controller, const std::string& line, Reply reply) {
  if (is_too_deep(line))
    return reply.send(refusal_of(
        Json(), "a line has no more than " + std::to_string(kMaxDepth) + " arrays and objects in one another"));
  const Json request = Json::parse(line, nullptr, false);
  if (!request.is_object()) return reply.send(refusal_of(Json(), check_line(line).problem));
  const Json id = request.value("id", Json());
  const auto refuse = [&](const std::string& what) { reply.send(refusal_of(id, what)); };
  if (id.is_structured()) return reply.send(refusal_of(Json(), "`id` is a number or a string"));
  const auto found = request.find("do");
  const std::string what = found != request.end() && found->is_string() ? found->get<std::string>() : "";
  std::set<std::string> names;
  std::uint64_t count = 0;
  for (const RequestKind& kind : kRequests) {
    if (kind.name == what && kind.role > reply.role)
      return refuse("`" + what + "` takes the role of " + with_article(kind.role) + ": this client is " +
                    with_article(reply.role));
  }
  if (what == "post") {
    const std::string wrong = post(controller, request);
    return wrong.empty() ? reply.send(line_of(answer_to(id))) : refuse(wrong);
  }
  if (what == "hello") {
    if (const std::string wrong = role_of(request, reply.role); !wrong.empty()) return refuse(wrong);
    reply.take_role(reply.role);
    Json answer = answer_to(id);
    answer["format"] = "bipc-serve";
    answer["version"] = 1;
    answer["model"] = controller.image().name;
    answer["role"] = role_name(reply.role);
    answer["ports"] = ports_of(controller);
    if (controller.requests().any()) answer["services"] = services_of(controller.requests());
    return reply.send(line_of(answer));
  }
  if (what == "request") {
    const auto service = request.find("service"), input = request.find("input");
    if (service == request.end() || !service->is_string()) return refuse("`service` is missing, \"MODULE.SERVICE\"");
    const bool is_whole = input != request.end() && (input->is_object() || input->is_array());
    if (input != request.end() && !input->is_string() && !is_whole) return refuse("`input` is a text or an object");
    if (const auto name = service->get<std::string>(); name.ends_with(".abort_activity")) {
      const bool is_sound = is_whole && input->is_object() && input->size() == 1 && input->contains("id");
      std::uint64_t number = 0;
      if (!is_sound || !count_of(*input, "id", 0, number))
        return refuse("input of `" + name + "`: an object with `id`, the number of a request");
      std::optional<RequestReply> at_once;
      const std::string problem = controller.requests().abort_activity(name, number, reply.client, count, at_once);
      if (!problem.empty()) return refuse(problem);
      Json answer = answer_to(id);
      answer["request"] = count;
      reply.send(line_of(answer));
      if (at_once && controller.requests().on_reply) controller.requests().on_reply(*at_once);
      return;
    }
    const std::string wrong = controller.requests().ask(service->get<std::string>(),
                                                        input == request.end() ? ""
                                                        : is_whole             ? input->dump()
                                                                               : input->get<std::string>(),
                                                        reply.client, count);
    if (!wrong.empty()) return refuse(wrong);
    Json answer = answer_to(id);
    answer["request"] = count;
    return reply.send(line_of(answer));
  }
  if (what == "cancel") {
    if (!count_of(request, "request", ~0ull, count)) return refuse("`request` is a number that `request` gave");
    const std::string wrong = controller.requests().cancel(count, reply.client);
    return wrong.empty() ? reply.send(line_of(answer_to(id))) : refuse(wrong);
  }
  if (what == "codels") {
    if (controller.requests().codel_times == nullptr) return refuse("the model calls no codels");
    Json answer = answer_to(id);
    answer["codels"] = Json::parse(controller.requests().codel_times(), nullptr, false);
    return reply.send(line_of(answer));
  }
  if (what == "poster") {
    const auto name = request.find("poster");
    if (name == request.end() || !name->is_string()) return refuse("`poster` is missing, \"MODULE.POSTER\"");
    return ask(controller, reply, id, [poster = name->get<std::string>()](Controller& c, Json& answer) {
      return poster_of(c.requests(), poster, answer);
    });
  }
  if (what == "requests") {
    Json answer = answer_to(id);
    answer["requests"] = Json::array();
    for (const Requests::Row& row : controller.requests().open())
      answer["requests"].push_back({{"request", row.request}, {"service", row.service}, {"running", row.is_running}});
    return reply.send(line_of(answer));
  }
  if (what == "subscribe" || what == "unsubscribe" || what == "break") {
    std::set<std::string> ports;
    if (!texts_of(request, "interactions", names)) return refuse("`interactions` is an array of names");
    if (!texts_of(request, "ports", ports)) return refuse("`ports` is an array of ends of paths");
    const bool names_steps = !names.empty() || !ports.empty();
    const auto wanted = request.find("requests");
    if (wanted != request.end() && !wanted->is_boolean()) return refuse("`requests` is true or false");
    const bool hears_requests = what == "subscribe" && wanted != request.end() && wanted->get<bool>();
    std::set<std::string> interactions;
    for (const std::string& name : names) interactions.insert(rt::whole_path(name));
    const Subscription steps{what == "break" ? names_steps : what == "subscribe" && (names_steps || !hears_requests),
                             std::move(interactions),
                             {ports.begin(), ports.end()},
                             hears_requests};
    what == "break" ? reply.break_at(steps) : reply.subscribe(steps);
    return reply.send(line_of(answer_to(id)));
  }
  if (what == "state") {
    if (!texts_of(request, "atoms", names)) return refuse("`atoms` is an array of paths");
    const std::optional<std::set<std::string>> asked = request.contains("atoms") ? std::optional(names) : std::nullopt;
    return ask(controller, reply, id, [asked](Controller& c, Json& answer) {
      answer["time"] = c.system().now();
      answer["steps"] = c.system().steps();
      answer["late"] = c.system().late_steps();
      answer["paused"] = c.is_paused();
      answer["ended"] = c.has_ended();
      answer["atoms"] = Json::object();
      return state_of(c, asked, answer["atoms"]);
    });
  }
  if (what == "candidates") {
    return ask(controller, reply, id, [](Controller& c, Json& answer) {
      answer["steps"] = c.system().steps();
      answer["count"] = c.system().candidate_count();
      answer["candidates"] = candidates_of(c.system());
      return std::string();
    });
  }
  if (what == "why") {
    const auto path = request.find("path");
    if (path == request.end() || !path->is_string()) return refuse("`path` is the path of an interaction or a port");
    return ask(controller, reply, id, [name = path->get<std::string>()](Controller& c, Json& answer) {
      if (c.system().outcome() == Outcome::Fault) return std::string("the run has ended by an error");
      const std::string why = c.system().why(name);
      answer["why"] = why;
      return why.empty() ? "there is no interaction or port `" + name + "`" : std::string();
    });
  }
  if (what == "fire") {
    if (!count_of(request, "candidate", ~0ull, count)) return refuse("`candidate` is a number that `candidates` gave");
    std::uint64_t steps = 0;
    if (!count_of(request, "steps", ~0ull, steps)) return refuse("`steps` is a number that `candidates` gave");
    return ask(controller, reply, id, [count, steps](Controller& c, Json&) {
      if (steps != ~0ull && steps != c.system().steps())
        return "the model has taken " + std::to_string(c.system().steps()) + " steps, not " + std::to_string(steps);
      return c.fire(count);
    });
  }
  if (what == "back") {
    if (!count_of(request, "count", 1, count) || count == 0) return refuse("`count` is a whole number from 1 on");
    return ask(controller, reply, id, [count](Controller& c, Json&) { return c.back(count); });
  }
  if (what == "pause" || what == "resume") {
    return ask(controller, reply, id, [pauses = what == "pause"](Controller& c, Json&) {
      if (pauses) c.pause();
      else c.resume(0);
      return std::string();
    });
  }
  if (what == "step") {
    if (!count_of(request, "count", 1, count) || count == 0) return refuse("`count` is a whole number from 1 on");
    return ask(controller, reply, id, [count](Controller& c, Json&) {
      if (c.has_ended()) return std::string("the run has ended");
      c.resume(count);
      return std::string();
    });
  }
  if (what == "snapshot") {
    return ask(controller, reply, id, [](Controller& c, Json& answer) {
      std::size_t number = 0;
      if (!c.save(number)) return std::string("no more than 16 snapshots are kept");
      answer["snapshot"] = number;
      return std::string();
    });
  }
  if (what == "restore") {
    if (!count_of(request, "snapshot", ~0ull, count)) return refuse("`snapshot` is a number that `snapshot` gave");
    return ask(controller, reply, id, [count](Controller& c, Json&) {
      return c.restore(count) ? std::string() : std::string("there is no such snapshot");
    });
  }
  if (what == "shutdown") {
    reply.send(line_of(answer_to(id)));
    return reply.shut_down();
  }
  refuse(what.empty() ? "`do` is missing" : "`" + what + "` is not known");
}

bool Subscription::wants(const Step& step) const {
  if (!is_on) return false;
  if ((interactions.empty() && ports.empty()) || interactions.contains(step.interaction)) return true;
  for (const std::string& path : step.ports) {
    for (const std::string& end : ports) {
      if (path.ends_with(end) && (path.size() == end.size() || path[path.size() - end.size() - 1] == '.')) return true;
    }
  }
  return false;
}

std::string step_line(const Step& step, std::int64_t now, const char* note) {
  Json line = {
      {"note", note}, {"step", step.number}, {"time", now}, {"interaction", step.interaction}, {"ports", step.ports}};
  for (const StepValue& v : step.values) {
    std::visit([&](const auto& value) { line["values"][step.ports[v.port]][v.name] = value; }, v.value);
  }
  return line_of(line);
}

std::string request_line(const RequestReply& reply, std::int64_t now) {
  Json line{{"note", "request"},
            {"request", reply.request},
            {"service", reply.service},
            {"time", now},
            {"reply", reply.is_final ? "final" : "intermediate"},
            {"report", reply.report}};
  const Json more = Json::parse(reply.result, nullptr, false);
  if (more.is_object()) line.update(more);
  return line_of(line);
}

std::string alarm_line(const Alarm& alarm) {
  const char* const note = alarm.kind == Alarm::Kind::Stalled     ? "stalled"
                           : alarm.kind == Alarm::Kind::RunsAgain ? "runs again"
                           : alarm.kind == Alarm::Kind::Stopped   ? "stopped"
                                                                  : "late";
  return line_of({{"note", note}, {"ns", alarm.ns}, {"text", alarm.text}});
}

std::string end_line(Outcome outcome, const std::string& text) {
  return line_of({{"note", "end"},
                  {"outcome", outcome == Outcome::Fault   ? "error"
                              : outcome == Outcome::Final ? "final"
                                                          : "deadlock"},
                  {"text", text}});
}

std::string error_line(const std::string& what) { return refusal_of(Json(), what); }

}  // namespace bip::serve
