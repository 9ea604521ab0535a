// See part_of_trace.hpp.
#include "compiler/traces/part_of_trace.hpp"

#include <algorithm>
#include <set>
#include <string_view>

#include <nlohmann/json.hpp>

#include "bip/assert.hpp"
#include "compiler/base/json_text.hpp"

namespace bip::traces {

std::string wanted_lines(const std::string& text, const std::vector<bool>& wanted) {
  std::string out;
  std::size_t row = 0;
  for (std::size_t at = 0; at < text.size(); ++row) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    if (row == 0 || row > wanted.size() || wanted[row - 1]) out.append(text, at, end - at);
    at = end;
  }
  return out;
}

namespace {

/// Is the event, on a line of its own, one of the part? `left_out` gets the tracks whose names say that they are not.
bool is_wanted_event(std::string_view line, const std::vector<bool>& wanted, const Selection& selection,
                     std::set<std::uint64_t>& left_out) {
  const nlohmann::ordered_json event = parse_json(line);
  if (!event.is_object()) return true;
  const auto arguments = event.find("args"), track = event.find("tid");
  if (track == event.end() || !track->is_number_unsigned()) return true;
  const std::uint64_t number = track->get<std::uint64_t>();
  const auto name =
      arguments == event.end() ? nlohmann::ordered_json() : arguments->value("name", nlohmann::ordered_json());
  // Track 0 is that of interactions.
  if (event.value("name", "") == "thread_name" && number != 0 && name.is_string() && !selection.components.empty() &&
      !selection.takes_component(name.get<std::string>()))
    left_out.insert(number);
  if (left_out.contains(number)) return false;
  const auto step =
      arguments == event.end() ? nlohmann::ordered_json() : arguments->value("step", nlohmann::ordered_json());
  if (!step.is_number_unsigned()) return true;
  const std::uint64_t row = step.get<std::uint64_t>();
  return row < wanted.size() && wanted[static_cast<std::size_t>(row)];
}

}  // namespace

std::string wanted_events(const std::string& text, const std::vector<bool>& wanted, const Selection& selection) {
  const std::size_t begin = text.find('\n') + 1, end = text.rfind("\n]}");
  BIP_ASSERT(begin != 0 && end != std::string::npos && begin <= end + 1, "a Perfetto trace from {} to {}", begin, end);
  std::string out = text.substr(0, begin);
  std::set<std::uint64_t> left_out;
  bool is_first = true;
  for (std::size_t at = begin; at < end;) {
    const std::size_t next = std::min(text.find('\n', at), end);
    std::string_view line = std::string_view(text).substr(at, next - at);
    if (line.ends_with(',')) line.remove_suffix(1);
    at = next + 1;
    if (!is_wanted_event(line, wanted, selection, left_out)) continue;
    if (!is_first) out += ",\n";
    is_first = false;
    out += line;
  }
  return out + "\n]}\n";
}

}  // namespace bip::traces
