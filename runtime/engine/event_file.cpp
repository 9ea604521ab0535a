// See event_file.hpp.
#include "runtime/engine/event_file.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <limits>

#include "bip/assert.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/json_line.hpp"
#include "runtime/engine/line_reader.hpp"
#include "runtime/engine/policies.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

namespace {

EventValue value_of(JsonLine& json, CellType type) {
  switch (json.kind()) {
    case JsonLine::Kind::Bool: return json.boolean();
    case JsonLine::Kind::String: {
      std::string text = json.string();
      // As traces write floats that JSON has no word for.
      if (type != CellType::Float) return text;
      if (text == "nan") return std::numeric_limits<double>::quiet_NaN();
      if (text == "inf") return std::numeric_limits<double>::infinity();
      if (text == "-inf") return -std::numeric_limits<double>::infinity();
      return text;
    }
    case JsonLine::Kind::Number: {
      if (type == CellType::Float) return json.real();
      const std::int64_t whole = json.integer();
      if (json.ok() && (whole < INT32_MIN || whole > INT32_MAX)) json.fail("the number does not fit an int");
      return static_cast<std::int32_t>(whole);
    }
    case JsonLine::Kind::Object:
    case JsonLine::Kind::Array:
    case JsonLine::Kind::Null:
    case JsonLine::Kind::Other: break;
  }
  json.fail("a value was expected: a number, a string, true or false");
  return std::int32_t{0};
}

void append_real(std::string& out, double value) {
  const bool quoted = !std::isfinite(value);
  if (quoted) out += '"';
  append_double(out, value);
  if (quoted) out += '"';
}

// {"x":1} or [1]
void read_values(JsonLine& json, const EventPorts& ports, Event& event) {
  const Span<Var>& vars = ports.vars(event.row);
  if (json.kind() == JsonLine::Kind::Array) {
    for (bool more = json.open('['); more; more = json.next(']')) {
      const std::size_t k = event.values.size();
      event.values.push_back(value_of(json, k < vars.size ? vars[k].type : CellType::Int));
    }
    return;
  }
  BIP_ASSERT(event.values.empty(), "{} values were read before", event.values.size());
  std::vector<bool> is_given(vars.size);
  event.values.assign(vars.size, std::int32_t{0});
  for (bool more = json.open('{'); more; more = json.next('}')) {
    const std::string name = json.string();
    u32 k = 0;
    while (k < vars.size && name != vars[k].name) ++k;
    if (!json.take(':')) return;
    if (k == vars.size) return json.fail("port `" + ports.path(event.row) + "` has no variable `" + name + "`");
    if (is_given[k]) return json.fail("`" + name + "` comes twice");
    is_given[k] = true;
    event.values[k] = value_of(json, vars[k].type);
  }
  for (u32 k = 0; k < vars.size; ++k) {
    if (!is_given[k]) json.fail("`" + std::string(vars[k].name) + "` is missing");
  }
}

// False: it is the first or the last line of a record.
bool read_event(JsonLine& json, const EventPorts& ports, EventSource source, Event& event) {
  bool has_time = false, has_port = false, has_values = false;
  for (bool more = json.open('{'); more; more = json.next('}')) {
    const std::string key = json.string();
    if (!json.take(':')) return true;
    if (key == "format" || key == "end") return false;
    if (key == "time") {
      has_time = true;
      event.time = json.kind() == JsonLine::Kind::String ? parse_time(json.string()) : json.integer();
      if (event.time < 0 || event.time > kMaxTicks) json.fail("`time` is no instant: ns, or a text like \"1s500ms\"");
    } else if (key == "look") {
      event.look = static_cast<u64>(json.integer());
    } else if (key == "port") {
      const std::string path = json.string();
      event.row = ports.find(path);
      has_port = event.row != kNone;
      if (!has_port) json.fail("there is no port `" + path + "` for events from outside");
    } else if (source == EventSource::Record && (key == "return" || key == "overrun")) {
      const std::string path = json.string();
      event.kind = key == "return" ? EventKind::Return : EventKind::Overrun;
      event.row = ports.find_atom(path);
      has_port = event.row != kNone;
      if (!has_port) json.fail("there is no component `" + path + "` with actions that run beside the others");
    } else if (source == EventSource::Record && key == "resumes") {
      event.kind = EventKind::Resume;
      event.until = json.integer();
      if (event.until < event.time || event.until > kMaxTicks) json.fail("`resumes` is no instant after `time`, in ns");
      has_port = true;
    } else if (key == "values") {
      if (!has_port || event.kind != EventKind::Port) json.fail("`values` comes before `port`");
      else read_values(json, ports, event);
      has_values = true;
    } else {
      json.fail("`" + key + "` is not known: `time`, `port`, `values` and `look` are");
    }
  }
  if (!has_time) json.fail("`time` is missing");
  if (!has_port) json.fail("`port` is missing");
  if (!json.at_end() || event.kind != EventKind::Port) return true;
  if (std::string problem = ports.check(event.row, event.values); !problem.empty())
    json.fail(has_values ? problem : problem + ": `values` is missing");
  return true;
}

}  // namespace

i64 parse_time(std::string_view text) {
  constexpr std::pair<std::string_view, i64> kUnits[] = {
      {"s", 1'000'000'000}, {"ms", 1'000'000}, {"us", 1'000}, {"ns", 1}};
  if (text == "0") return 0;
  Int128 total = 0;
  std::size_t at = 0, unit = 0;
  while (at < text.size()) {
    i64 count = 0;
    const std::size_t first = at;
    for (; at < text.size() && text[at] >= '0' && text[at] <= '9' && count < kMaxTicks / 10; ++at)
      count = count * 10 + (text[at] - '0');
    if (at == first) return -1;
    std::size_t end = at;
    while (end < text.size() && text[end] >= 'a' && text[end] <= 'z') ++end;
    // The largest unit comes first.
    while (unit < std::size(kUnits) && kUnits[unit].first != text.substr(at, end - at)) ++unit;
    if (unit == std::size(kUnits)) return -1;
    total += static_cast<Int128>(count) * kUnits[unit++].second;
    at = end;
  }
  BIP_ASSERT(at == text.size(), "a time is read up to {} of {}", at, text.size());
  return text.empty() || total > kMaxTicks ? -1 : static_cast<i64>(total);
}

namespace {

// A last line without its newline that cannot be read is where the writer of a record was ended.
enum class TornEnd : std::uint8_t { IsCut, IsError };

// Torn: the last line was cut off.
enum class FileEnd : std::uint8_t { Whole, Torn };

// Calls on_line(json) for each line that is not empty, until one is wrong. Longer lines than LineReader::kMaxLine are
// no events.
template <class OnLine>
Result<FileEnd> read_lines(const std::string& path, TornEnd torn, bool (*is_stopped)(), const OnLine& on_line) {
  LineReader in(path, is_stopped);
  std::string line;
  LineReader::Got got = in.next(line);
  for (std::size_t number = 1; got == LineReader::Got::Line; ++number) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) {
      JsonLine json(line.size() > LineReader::kMaxLine ? std::string_view() : std::string_view(line));
      on_line(json, number);
      if (!json.ok() && in.is_torn() && torn == TornEnd::IsCut) return FileEnd::Torn;
      if (!json.ok()) return Failure{path + ":" + std::to_string(number) + ": " + json.error()};
    }
    got = in.is_torn() ? LineReader::Got::End : in.next(line);
  }
  if (got == LineReader::Got::End) return FileEnd::Whole;
  return Failure{"cannot read `" + path +
                 "`: " + (got == LineReader::Got::Stopped ? "interrupted" : std::strerror(errno))};
}

template <class Word>
Word word_of(JsonLine& json, std::initializer_list<Word> words) {
  const std::string text = json.string();
  for (const Word word : words) {
    if (text == name_of(word)) return word;
  }
  json.fail("`" + text + "` is not known");
  return *words.begin();
}

Policy policy_of(JsonLine& json) {
  const std::string name = json.string();
  if (const PolicyRow* const row = find_policy(name)) return row->policy;
  json.fail("`" + name + "` is not known");
  return Policy::Uniform;
}

// Of the first or the last line; what others wrote into them is skipped over if it is no bracket.
void read_record_line(JsonLine& json, Record& out, bool& is_first) {
  for (bool more = json.open('{'); more; more = json.next('}')) {
    const std::string key = json.string();
    if (!json.take(':')) return;
    if (key == "format") is_first = json.string() == "bipc-events";
    else if (key == "version") json.integer() == 1 ? void() : json.fail("version 1 was expected");
    else if (key == "model") out.model = json.string();
    else if (key == "seed") out.seed = static_cast<u64>(json.integer());
    else if (key == "policy") out.policy = policy_of(json);
    else if (key == "asap") out.asap = json.boolean();
    else if (key == "returns") out.tells_returns = json.boolean();
    else if (key == "resumes") out.draws_resumes = json.string() == "drawn";
    else if (key == "maximal_progress") out.maximal_progress = json.boolean();
    else if (key == "end")
      out.has_end = true,
      out.end = word_of(json, {End::Limit, End::Deadlock, End::Fault, End::Interrupted, End::Final});
    else if (key == "steps") out.steps = static_cast<u64>(json.integer());
    else if (key == "looks") out.looks = static_cast<u64>(json.integer());
    else if (key == "time") (void)json.integer();
    else return json.fail("`" + key + "` is not known");
  }
  (void)json.at_end();
}

}  // namespace

Result<Record> read_record(const std::string& path) {
  constexpr const char* kNoRecord = "this is no record of a run: --record writes one";
  Record record;
  bool is_record = false, has_head = false;
  const Result<FileEnd> end = read_lines(path, TornEnd::IsCut, nullptr, [&](JsonLine& json, std::size_t number) {
    if (number != 1 && json.first_key() != "end") return;
    if (number == 1 && json.first_key() != "format") return json.fail(kNoRecord);
    read_record_line(json, record, is_record);
    if (number == 1 && !is_record && json.ok()) json.fail(kNoRecord);
    has_head = has_head || (number == 1 && json.ok());
  });
  if (!end) return Failure{end.error()};
  if (!is_record) return Failure{path + ": " + kNoRecord};
  if (!has_head) return Failure{path + ":1: this line is cut off, and with it the seed and the options of the run"};
  record.is_torn = *end == FileEnd::Torn;
  if (record.is_torn) record.has_end = false;
  return record;
}

void append_record_head(std::string& out, const Record& record) {
  out += R"({"format":"bipc-events","version":1,"model":)";
  append_quoted(out, record.model.c_str());
  out += R"(,"seed":)";
  append_number(out, record.seed);
  out += std::string(R"(,"policy":")") + name_of(record.policy) + R"(","asap":)" + (record.asap ? "true" : "false");
  out += std::string(R"(,"maximal_progress":)") + (record.maximal_progress ? "true" : "false") +
         (record.draws_resumes ? R"(,"resumes":"drawn")" : "") +
         (record.tells_returns ? ",\"returns\":true}\n" : "}\n");
}

void append_record_end(std::string& out, const Record& record) {
  out += std::string(R"({"end":")") + name_of(record.end) + R"(","steps":)";
  append_number(out, record.steps);
  out += R"(,"looks":)";
  append_number(out, record.looks);
  out += "}\n";
}

Result<std::vector<Event>> read_events(const std::string& path, const EventPorts& ports, EventSource source,
                                       bool (*is_stopped)()) {
  std::vector<Event> events;
  const TornEnd torn = source == EventSource::Record ? TornEnd::IsCut : TornEnd::IsError;
  const Result<FileEnd> end = read_lines(path, torn, is_stopped, [&](JsonLine& json, std::size_t) {
    Event event;
    if (!read_event(json, ports, source, event)) return;
    if (json.ok() && !events.empty() && event.time < events.back().time)
      json.fail("events come in the order of their time");
    if (json.ok()) events.push_back(std::move(event));
  });
  if (!end) return Failure{end.error()};
  return events;
}

void append_event(std::string& out, const EventPorts& ports, const Event& event) {
  out += R"({"time":)";
  BIP_ASSERT(event.time >= 0, "an event at {}", event.time);
  append_number(out, static_cast<u64>(event.time));
  if (event.look != kAnyLook) {
    out += R"(,"look":)";
    append_number(out, event.look);
  }
  if (event.kind == EventKind::Resume) {
    out += R"(,"resumes":)";
    append_number(out, static_cast<u64>(event.until));
    out += "}\n";
    return;
  }
  if (event.kind != EventKind::Port) {
    out += event.kind == EventKind::Return ? R"(,"return":)" : R"(,"overrun":)";
    append_quoted(out, ports.atom_path(event.row).c_str());
    out += "}\n";
    return;
  }
  out += R"(,"port":)";
  BIP_ASSERT(event.values.size() == ports.vars(event.row).size, "{} values for {} variables", event.values.size(),
             ports.vars(event.row).size);
  append_quoted(out, ports.path(event.row).c_str());
  const Span<Var>& vars = ports.vars(event.row);
  if (vars.size != 0) out += R"(,"values":{)";
  for (u32 i = 0; i < vars.size; ++i) {
    if (i != 0) out += ',';
    append_quoted(out, vars[i].name);
    out += ':';
    if (const auto* truth = std::get_if<bool>(&event.values[i])) out += *truth ? "true" : "false";
    else if (const auto* whole = std::get_if<std::int32_t>(&event.values[i])) out += std::to_string(*whole);
    else if (const auto* text = std::get_if<std::string>(&event.values[i])) append_quoted(out, text->c_str());
    else append_real(out, std::get<double>(event.values[i]));
  }
  out += vars.size != 0 ? "}}\n" : "}\n";
}

}  // namespace bip::rt
