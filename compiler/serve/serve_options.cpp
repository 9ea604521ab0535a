// See serve_options.hpp.
#include "compiler/serve/serve_options.hpp"

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <optional>

#include "runtime/engine/event_file.hpp"
#include "runtime/engine/policies.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::serve {

namespace {

std::optional<std::uint64_t> whole_number(const std::string& text) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

template <class Number>
std::string read_number(const std::string& text, std::uint64_t least, std::uint64_t greatest, const char* range,
                        Number& into) {
  const std::optional<std::uint64_t> number = whole_number(text);
  if (!number || *number < least || *number > greatest) return "`" + text + "` is not a whole number " + range;
  into = static_cast<Number>(*number);
  return {};
}

std::string read_duration(const std::string& text, std::int64_t& ns) {
  const std::int64_t read = rt::parse_time(text);
  if (read < 0) return "`" + text + "` is no duration such as 1s500ms";
  ns = read;
  return {};
}

// Of what is looked at again and again.
std::string read_wait(const std::string& text, std::int64_t& ns) {
  std::string wrong = read_duration(text, ns);
  return wrong.empty() && ns < 1'000'000 ? "`" + text + "` is less than 1ms" : wrong;
}

std::string read_speed(const std::string& text, double& speed) {
  char* end = nullptr;
  errno = 0;
  const double read = std::strtod(text.c_str(), &end);
  // A comparison with NaN is false.
  if (text.empty() || *end != '\0' || errno != 0 || !(read >= 1e-6 && read <= 1e6))
    return "`" + text + "` is not a number from 0.000001 to 1000000";
  speed = read;
  return {};
}

std::string read_path(const std::string& text, std::string& path) {
  if (text.empty()) return "a path is no empty word";
  path = text;
  return {};
}

// Formats that are written while steps are taken.
std::string formats_shown() {
  std::string shown;
  for (const rt::TraceFormatRow& row : rt::trace_formats()) {
    if (row.can_embed) shown += shown.empty() ? row.name : std::string("|") + row.name;
  }
  return shown;
}

std::string formats_help() {
  std::string help;
  for (const rt::TraceFormatRow& row : rt::trace_formats()) {
    if (row.can_embed && *row.help != '\0') help += std::string(help.empty() ? ": " : ", ") + row.name + ' ' + row.help;
  }
  return help;
}

std::string policies_shown() {
  std::string shown;
  for (const rt::PolicyRow& row : rt::policies()) shown += shown.empty() ? row.name : std::string("|") + row.name;
  return shown;
}

std::string not_one_of(const std::string& text, const std::string& shown) {
  return "`" + text + "` is not one of " + shown;
}

std::string read_policy(const std::string& text, ServeSettings& settings) {
  const rt::PolicyRow* const row = rt::find_policy(text);
  if (row == nullptr) return not_one_of(text, policies_shown());
  settings.policy = row->policy;
  return {};
}

std::string read_format(const std::string& text, ServeSettings& settings) {
  const rt::TraceFormatRow* const row = rt::find_trace_format(text);
  if (row == nullptr || !row->can_embed) return not_one_of(text, formats_shown());
  settings.trace_format = row->format;
  return {};
}

std::string read_port(const std::string& text, ServeSettings& settings) {
  std::string wrong = read_number(text, 0, std::numeric_limits<std::uint16_t>::max(), "from 0 to 65535", settings.port);
  settings.has_port = settings.has_port || wrong.empty();
  return wrong;
}

using Settings = ServeSettings;
using Text = const std::string&;

}  // namespace

const std::vector<ServeOption>& serve_options() {
  static const std::vector<ServeOption> options{
      {"--socket", "PATH", "accept clients at the Unix socket PATH (default: one client, on standard input and output)",
       [](Text text, Settings& s) { return read_path(text, s.socket); }},
      {"--port", "N",
       "accept clients at TCP port N of 127.0.0.1 (0: a free one) that know the token printed to standard error",
       read_port},
      {"--paused", "", "start paused, until a client sends `resume` or `step`",
       [](Text, Settings& s) {
         s.paused = true;
         return std::string();
       }},
      {"--seed", "N", "seed of the random choices (default: 0)",
       [](Text text, Settings& s) {
         return read_number(text, 0, std::numeric_limits<std::uint64_t>::max(), "from 0 to 2^64 - 1", s.seed);
       }},
      {"--policy", policies_shown(), "how the next step is chosen among the candidates (default: uniform)",
       read_policy},
      {"--asap", "", "take each step at the earliest instant at which it is possible",
       [](Text, Settings& s) {
         s.asap = true;
         return std::string();
       }},
      {"--speed", "F", "seconds of model time per second (default: 1)",
       [](Text text, Settings& s) { return read_speed(text, s.speed); }},
      {"--real-time-priority", "N",
       "in real time, run with scheduling priority N (SCHED_FIFO, 1 to 99) and locked memory; a refusal is a warning",
       [](Text text, Settings& s) { return read_number(text, 1, 99, "from 1 to 99", s.real_time_priority); }},
      {"--stall-after", "TIME",
       "when no step has returned for TIME, or steps begin TIME too late, print a warning and call the safe-stop "
       "function, if there is one (default: 1s if the model's C++ has one, else 0: never)",
       [](Text text, Settings& s) { return read_duration(text, s.stall_after); }},
      {"--safe-stop", "NAME",
       "the C function of the model's C++ that stops the robot, `extern \"C\" void NAME(const char* why)` (default: "
       "safe_stop, if there is one)",
       [](Text text, Settings& s) {
         s.safe_stop = text;
         return std::string();
       }},
      {"--late-after", "TIME",
       "print a warning when steps begin more than this late, at most one a second (default: 100ms; 0: never)",
       [](Text text, Settings& s) { return read_duration(text, s.late_after); }},
      {"--silent-after", "TIME",
       "call the safe-stop function when clients that have posted events or asked for services send nothing for so "
       "long (default: 0: never)",
       [](Text text, Settings& s) { return read_duration(text, s.silent_after); }},
      {"--trace", "PATH", "write a trace of the steps to PATH; the file is complete when the process has ended",
       [](Text text, Settings& s) { return read_path(text, s.trace_path); }},
      {"--trace-format", formats_shown(), "format of the trace" + formats_help() + " (default: json)", read_format},
      {"--close-after", "TIME", "", [](Text text, Settings& s) { return read_wait(text, s.close_after); }},
      {"--idle-after", "TIME", "", [](Text text, Settings& s) { return read_wait(text, s.idle_after); }},
  };
  return options;
}

}  // namespace bip::serve
